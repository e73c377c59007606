"""Duals carry the derivatives that differences find, through whatever NumPy code they pass."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robolaser.duals import LINEAR, PARTIALS, RULES, Dual, bare, is_dual
from robolaser.geometry.rigid_motion import apply, carry, exp_so3, from_angles, from_quaternion, inverse, log_so3, pose

STEP = 1e-6
RNG = np.random.default_rng(0)
TURNS = exp_so3(RNG.normal(size=(2, 3, 3)))
ROWS = np.array([0, 2, 1, 0])


def filled(x: Any) -> Any:
    out = np.zeros_like(x, shape=(2, 3, 2))
    out[..., 0] = x
    out[..., 1] = 2.0 * x * x
    out[0, 1] = 5.0
    out[1, [0, 2]] = out[0, [2, 0]]
    return out


def accumulated(x: Any) -> Any:
    total = np.sin(x)
    total += x * x
    total *= x
    return total


CODE: dict[str, tuple[Callable[..., Any], tuple[int, ...], tuple[int, ...]]] = {
    "matmul": (np.matmul, (2, 3, 3), (3, 3)),
    "matmul of more": (lambda a, b: a[:, None] @ b, (2, 3, 3), (2, 4, 3, 3)),
    "broadcast": (lambda a, b: a[:, None] / (2.0 + b), (2, 3), (4, 3)),
    "concatenate": (lambda a, b: np.concatenate([a, np.ones((2, 3)), b], axis=0), (2, 3), (2, 3)),
    "stack": (lambda a, b: np.stack([a, b, np.ones((2, 3)), a * b], axis=-1), (2, 3), (2, 3)),
    "stack amid": (lambda a, b: np.stack([a, b], axis=1), (2, 3), (2, 3)),
    "where": (lambda a, b: np.where(a > b, a * b, 1.0), (2, 3), (2, 3)),
    "where of whole numbers": (lambda a, b: np.where(np.array([2, 0, -1]), a, b), (2, 3), (2, 3)),
    "einsum": (lambda a, b: np.einsum("cij,cj->ci", a, b), (2, 3, 3), (2, 3)),
    "einsum of any axes": (lambda a, b: np.einsum("...ij,...j->...i", a, b), (2, 4, 3, 3), (2, 4, 3)),
    "norm": (lambda a, b: np.linalg.norm(a - b, axis=-1), (2, 3), (2, 3)),
    "norm along another axis": (lambda a, b: np.linalg.norm(a + b, axis=0, keepdims=True), (2, 3), (2, 3)),
    "inv": (lambda a, b: np.linalg.inv(a + 3.0 * np.eye(3)) @ b, (2, 3, 3), (2, 3, 3)),
    "sinc": (lambda a, b: np.sinc(a) + b, (2, 3), (2, 3)),
    "clip": (lambda a, b: np.clip(a, b - 0.3, b + 0.3), (2, 3), (2, 3)),
    "max": (lambda a, b: (a * b).max(axis=1, keepdims=True) + np.max(a, axis=0), (2, 3), (2, 3)),
    "cross": (np.cross, (2, 3), (4, 1, 3)),
    "zeros_like": (lambda a, b: filled(a) * filled(b), (2, 3), (2, 3)),
    "in place": (lambda a, b: accumulated(a * b), (2, 3), (2, 3)),
    "broadcast_to": (lambda a, b: np.broadcast_to(a * b, (4, 2, 3)), (2, 3), (2, 3)),
    "swapaxes": (lambda a, b: np.swapaxes(a, 0, 1) @ b.swapaxes(-1, -2).swapaxes(0, 1), (2, 3), (2, 3)),
    "take": (lambda a, b: np.take(a, [1, 0, 1], axis=1) * b, (2, 3), (2, 3)),
    "take_along_axis": (
        lambda a, b: (
            np.take_along_axis(a * b, np.array([[0], [2]]), axis=1)
            + np.take_along_axis(a, np.array([[1, 0, 1]]), axis=0)
        ),
        (2, 3),
        (2, 3),
    ),
    "reshape": (lambda a, b: np.reshape(a, (3, 2)) * b.reshape(3, 2), (2, 3), (2, 3)),
    "sum": (lambda a, b: np.sum(a * b, axis=0) + a.sum(axis=-1, keepdims=True), (2, 3), (2, 3)),
    "mean": (lambda a, b: np.mean(a * b, axis=-1), (2, 3), (2, 3)),
    "diff": (lambda a, b: np.diff(a, axis=0) * np.diff(b, n=2), (2, 3), (2, 3)),
    "insert": (lambda a, b: np.insert(a * b, 1, 5.0, axis=1), (2, 3), (2, 3)),
    "copy": (lambda a, b: np.copy(a) * b, (2, 3), (2, 3)),
    "rows": (lambda a, b: a[:, ROWS % 3] * b[0, ROWS % 3], (2, 3), (2, 3)),
    "entries": (lambda a, b: a[[0, 1], :, [2, 0]] * b[np.array([True, False, True])], (2, 3, 3), (3, 3)),
    "mask": (lambda a, b: (a * b)[np.array([[True, False, True], [False, True, True]])], (2, 3), (2, 3)),
    "powers": (lambda a, b: (2.0 + a) ** 3 - 1.0 / b**2, (2, 3), (2, 3)),
    "angles": (lambda a, b: from_angles(*a) @ from_angles(*b, order="zyz"), (3, 2), (3, 2)),
    "motions": (lambda a, b: pose(from_angles(*a), b) @ inverse(pose(TURNS[0], b)), (3, 3), (3, 3)),
    "carried": (
        lambda a, b: carry(pose(from_angles(a[..., 0], a[..., 1], a[..., 2]), a), ROWS, b),
        (2, 3, 3),
        (2, 4, 3),
    ),
    "applied": (lambda a, b: apply(pose(from_angles(*a), b), b), (3, 3), (3, 3)),
    "exponential": (lambda a, b: exp_so3(a) @ exp_so3(b), (2, 3), (2, 3)),
    "logarithm": (lambda a, b: log_so3(exp_so3(a) @ exp_so3(b)), (2, 3), (2, 3)),
    "quaternions": (lambda a, b: from_quaternion(a) @ from_quaternion(b), (2, 4), (2, 4)),
}
LINEAR_CODE: dict[Any, Callable[[Any], Any]] = {
    np.cumsum: lambda x: np.cumsum(x, axis=1), np.expand_dims: lambda x: np.expand_dims(x, 1),
    np.flip: lambda x: np.flip(x, axis=0), np.moveaxis: lambda x: np.moveaxis(x, 0, -1), np.ravel: np.ravel,
    np.repeat: lambda x: np.repeat(x, 2, axis=0), np.roll: lambda x: np.roll(x, 1, axis=1),
    np.squeeze: np.squeeze, np.tile: lambda x: np.tile(x, 2), np.transpose: np.transpose,
}  # fmt: skip


def agrees(function: Callable[..., Any], *at: np.ndarray) -> None:
    """Whether the slopes of a function of arrays, each entry a parameter of its own, are those of differences."""
    first, arguments = 0, []
    for array in at:
        numbers = tuple(range(first, first + array.size))
        arguments.append(Dual(array, np.eye(array.size).reshape(-1, *array.shape), numbers))
        first += array.size
    found = function(*arguments)
    np.testing.assert_array_equal(bare(found), function(*at))
    assert found.slopes.shape == (len(found.of), *found.shape)
    flat = np.concatenate([array.ravel() for array in at])
    ends = np.cumsum([array.size for array in at])[:-1]
    for number in range(first):
        ahead, behind = (
            function(*(part.reshape(array.shape) for part, array in zip(np.split(flat + step, ends), at, strict=True)))
            for step in (STEP * np.eye(first)[number], -STEP * np.eye(first)[number])
        )
        slope = found.slopes[found.of.index(number)] if number in found.of else np.zeros(found.shape)
        np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * STEP), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("name", CODE)
def test_code_of_two_arrays_has_the_derivatives_of_differences(name):
    function, one, other = CODE[name]
    agrees(function, RNG.normal(size=one), RNG.normal(size=other))


@pytest.mark.parametrize("ufunc", PARTIALS, ids=lambda ufunc: ufunc.__name__)
def test_functions_of_numbers_have_the_derivatives_of_differences(ufunc):
    agrees(ufunc, *(RNG.uniform(0.1, 0.9, (2, 3)) for _ in range(ufunc.nin)))


@pytest.mark.parametrize(
    "function", sorted(LINEAR, key=lambda function: function.__name__), ids=lambda function: function.__name__
)
def test_functions_that_move_entries_about_move_derivatives_alike(function):
    agrees(LINEAR_CODE[function], RNG.normal(size=(2, 3)))


def test_every_function_that_is_offered_is_tried():
    assert {function.__name__ for function in RULES} - {"empty_like"} <= set(CODE)


@pytest.mark.parametrize("nothing", [0.0, 1e-12])
def test_the_logarithm_of_no_turn_moves_as_the_turn_does(nothing):
    turn = Dual(np.full((1, 3), nothing), np.eye(3)[:, None], (0, 1, 2))
    np.testing.assert_allclose(log_so3(exp_so3(turn)).slopes[:, 0], np.eye(3), atol=1e-9)


def test_comparisons_see_the_value_alone():
    x = Dual.parameter(np.array([1.0, -1.0]), 3)
    assert (x > 0.0).tolist() == [True, False]
    assert np.isfinite(x).all()
    assert not is_dual(np.argmax(x))


@pytest.mark.parametrize(
    "code",
    [
        np.asarray,
        lambda x: np.zeros((2, 3)).__setitem__((..., 0), x),
        np.add.reduce,
        lambda x: np.einsum("i,j", x, x),
        lambda x: np.linalg.norm(x[:, None] * x),
        lambda x: np.linalg.norm(x, 1),
        lambda x: np.diff(x, prepend=5.0),
        lambda x: np.diff(x, append=5.0),
    ],
)
def test_what_cannot_carry_derivatives_says_so(code):
    with pytest.raises(TypeError, match=r"np\.|_norm|_diff"):
        code(Dual.parameter(np.ones(2), 0))


def test_a_function_without_a_rule_names_those_that_have_one():
    with pytest.raises(TypeError, match=r"np\.sort has no derivative here: residuals may use .*stack"):
        np.sort(Dual.parameter(np.ones(2), 0))
