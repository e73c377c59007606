"""What is eliminated is the best there is within its bounds, whatever they are."""

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.optimize import least_squares

from robolaser import compiled
from robolaser.arrays import Array
from robolaser.estimation.elimination import placement, seats, similarity, tracker
from robolaser.estimation.elimination.loop import Loops
from robolaser.estimation.elimination.newton import minimise
from robolaser.estimation.elimination.turns import along, angles_within, turn
from robolaser.geometry.rigid_motion import apply, exp_so3, from_angles, inverse, pose

ORDERS = ["xyz", "zyz"]
BRACKET = exp_so3(np.array([0.3, -1.2, 0.7]))


@pytest.fixture(params=["compiled", "numpy"], autouse=True)
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    if request.param == "numpy":
        monkeypatch.setenv(compiled.SWITCH, "0")
        compiled.available.cache_clear()
    elif not compiled.available():
        pytest.skip("there is no compiler")
    yield
    compiled.available.cache_clear()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(8)


def on_flange(found: Array, p: Array, d: Array, order: str) -> Array:
    """Residuals of similarity fits, (c, m, 3)."""
    R = BRACKET @ from_angles(*found[:, 1:4].T, order=order)
    return d - (found[:, :1, None] * np.einsum("cij,cmj->cmi", R, p) + found[:, None, 4:])


def cost(residuals: Array) -> Array:
    return (residuals**2).sum(axis=(1, 2))


def seen_and_known(
    rng: np.random.Generator, c: int, order: str, *, noise: float, sign: float = 1.0
) -> tuple[Array, ...]:
    """Points in the camera frame on a flat sheet, the same in the flange frame, and the truth (c, 7)."""
    p = rng.normal(size=(c, 14, 3)) * [0.05, 0.03, 0.0] @ exp_so3(np.array([0.0, 0.5, 0.0])) + [0.02, 0.0, 0.3]
    truth = np.column_stack(
        [sign * rng.uniform(0.8, 1.2, c), rng.uniform(-0.2, 0.2, (c, 3)), rng.uniform(-0.05, 0.05, (c, 3))]
    )
    d = -on_flange(truth, p, np.zeros(1), order) + noise * rng.normal(size=p.shape)
    return p, d, truth


@pytest.mark.parametrize("order", ORDERS)
def test_derivatives_of_a_turn_are_those_of_differences(rng: np.random.Generator, order: str) -> None:
    angles, G, h = rng.uniform(-1, 1, (5, 3)), rng.normal(size=(5, 3, 3)), 1e-4

    def value(at: Array) -> Array:
        return (turn(at, order)[0] * G).sum(axis=(1, 2))

    R, axes = turn(angles, order)
    np.testing.assert_allclose(R, from_angles(*angles.T, order=order), atol=1e-15)
    first, second = along(axes, G @ np.swapaxes(R, 1, 2))
    steps = h * np.eye(3)
    slopes = np.stack([(value(angles + s) - value(angles - s)) / (2 * h) for s in steps], axis=-1)
    np.testing.assert_allclose(first, slopes, atol=1e-7)
    bends = [
        [value(angles + s + t) - value(angles + s - t) - value(angles - s + t) + value(angles - s - t) for s in steps]
        for t in steps
    ]
    np.testing.assert_allclose(second, np.moveaxis(np.array(bends), -1, 0) / (4 * h**2), atol=1e-6)


@pytest.mark.parametrize("order", ORDERS)
def test_angles_give_their_turn_back_on_the_branch_within_bounds(rng: np.random.Generator, order: str) -> None:
    middle = rng.uniform(-6, 6, 3)
    lower, upper = middle - 0.7, middle + 0.7
    angles = rng.uniform(lower, upper, (200, 3))
    R = from_angles(*angles.T, order=order)
    found = angles_within(R, order, lower, upper)
    np.testing.assert_allclose(from_angles(*found.T, order=order), R, atol=1e-12)
    assert ((found >= lower - 1e-9) & (found <= upper + 1e-9)).all()


def test_a_turn_without_a_middle_angle_has_angles_too() -> None:
    for order, phi in (("xyz", np.pi / 2), ("zyz", 0.0)):
        R = from_angles(*(np.array([a]) for a in (0.3, phi, 0.4)), order=order)
        found = angles_within(R, order, -np.ones(3), np.ones(3))
        np.testing.assert_allclose(from_angles(*found.T, order=order), R, atol=1e-12)


def test_newton_solves_box_bounded_quadratics_exactly(rng: np.random.Generator) -> None:
    A = rng.normal(size=(40, 8, 5))
    b = rng.normal(size=(40, 8))
    H, g = np.swapaxes(A, 1, 2) @ A, -np.einsum("kij,ki->kj", A, b)

    def objective(x: Array, which: Array) -> tuple[Array, Array, Array]:
        Hx = np.einsum("kij,kj->ki", H[which], x)
        return (x * (0.5 * Hx + g[which])).sum(axis=1), Hx + g[which], H[which]

    ends = np.full((40, 5), -0.2), np.full((40, 5), 0.2)
    found, _ = minimise(objective, np.zeros((40, 5)), *ends, np.ones(40))
    for i in range(40):
        theirs = least_squares(
            lambda x, i=i: A[i] @ x - b[i],
            np.zeros(5),
            jac=lambda x, i=i: A[i],
            bounds=(-0.2, 0.2),
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        np.testing.assert_allclose(found[i], theirs.x, atol=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("order", ORDERS)
def test_a_similarity_without_noise_is_found_whatever_its_sign(
    rng: np.random.Generator, order: str, sign: float
) -> None:
    p, d, truth = seen_and_known(rng, 30, order, noise=0.0, sign=sign)
    room = similarity.Room(BRACKET, order, np.array([[-0.25] * 3, [0.25] * 3]), np.array([[-0.06] * 3, [0.06] * 3]))
    found = similarity.fit(p, d, room, np.tile([-1.5, 1.5], (30, 1)))
    assert cost(on_flange(found, p, d, order)).max() < 1e-20
    np.testing.assert_allclose(found[:, 0], truth[:, 0], rtol=1e-7)


@pytest.mark.parametrize("order", ORDERS)
def test_a_bounded_similarity_is_what_scipy_finds(rng: np.random.Generator, order: str) -> None:
    c = 20
    p, d, _ = seen_and_known(rng, c, order, noise=0.01)
    lower, upper = np.array([0.9, *[-0.08] * 3, *[-0.02] * 3]), np.array([1.1, *[0.08] * 3, *[0.02] * 3])
    room = similarity.Room(BRACKET, order, np.stack([lower[1:4], upper[1:4]]), np.stack([lower[4:], upper[4:]]))
    found = similarity.fit(p, d, room, np.tile([lower[0], upper[0]], (c, 1)))
    assert ((found >= lower) & (found <= upper)).all()
    assert ((found == lower) | (found == upper)).any(axis=1).mean() > 0.9
    ours = cost(on_flange(found, p, d, order))
    for i in range(c):
        start = np.clip(found[i], lower + 1e-6, upper - 1e-6)
        theirs = least_squares(
            lambda x, i=i: on_flange(x[None], p[[i]], d[[i]], order).ravel(),
            start,
            bounds=(lower, upper),
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        assert ours[i] <= 2 * theirs.cost * (1 + 1e-9)


def test_a_point_at_a_pole_spoils_its_own_candidate_only(rng: np.random.Generator) -> None:
    p, d, _ = seen_and_known(rng, 4, "xyz", noise=0.001)
    room = similarity.Room(BRACKET, "xyz", np.array([[-0.1] * 3, [0.1] * 3]), np.array([[-0.1] * 3, [0.1] * 3]))
    scale = np.tile([0.5, 2.0], (4, 1))
    whole = similarity.fit(p, d, room, scale)
    p[2, 5] = np.inf
    spoilt = similarity.fit(p, d, room, scale)
    assert np.isnan(spoilt[2]).all()
    np.testing.assert_array_equal(spoilt[[0, 1, 3]], whole[[0, 1, 3]])


def flanges(rng: np.random.Generator, c: int, poses: int) -> Array:
    return pose(exp_so3(rng.normal(0, 0.6, (c, poses, 3))), rng.normal(0, 0.3, (c, poses, 3)))


def test_a_loops_form_is_the_sum_over_its_rows(rng: np.random.Generator) -> None:
    T = flanges(rng, 3, 8)
    chi, phi = rng.normal(size=(1, 8, 4)), rng.normal(size=(3, 8, 2))
    V, U = rng.normal(size=(3, 3, 4)), rng.normal(size=(3, 3, 2))
    left = np.einsum("cag,cmg->cma", V, np.broadcast_to(chi, (3, 8, 4))) - apply(T, np.einsum("caf,cmf->cma", U, phi))
    z = np.concatenate([V.reshape(3, -1), U.reshape(3, -1), np.ones((3, 1))], axis=1)
    loops = Loops.of(chi, phi, T[..., :3, :3], T[..., :3, 3])
    np.testing.assert_allclose(np.einsum("ci,cij,cj->c", z, loops.form, z), (left**2).sum(axis=(1, 2)), rtol=1e-12)


def test_what_a_form_loses_takes_its_best_values(rng: np.random.Generator) -> None:
    T = flanges(rng, 2, 8)
    loops = Loops.of(rng.normal(size=(2, 8, 4)), rng.normal(size=(2, 8, 2)), T[..., :3, :3], T[..., :3, 3])
    gone = np.array([3, 7, 11])
    Q, gives = loops.without(gone)
    rest = np.concatenate([rng.normal(size=(2, Q.shape[1] - 1)), np.ones((2, 1))], axis=1)
    z = np.zeros((2, loops.form.shape[1]))
    z[:, gone] = np.einsum("cki,ci->ck", gives, rest)
    z[:, np.setdiff1d(np.arange(z.shape[1]), gone)] = rest
    np.testing.assert_allclose(np.einsum("ci,cij,cj->c", z, loops.form, z), np.einsum("ci,cij,cj->c", rest, Q, rest))
    np.testing.assert_allclose(np.einsum("cij,cj->ci", loops.form, z)[:, gone], 0.0, atol=1e-10)


def around(truth: Array, half: float) -> tuple[Array, Array]:
    return truth - half, truth + half


@pytest.mark.parametrize("order", ORDERS)
def test_scanner_and_target_close_the_loops(rng: np.random.Generator, order: str) -> None:
    c, m = 6, 60
    truth = np.array([1.1, 0.1, -0.06, 0.08, 0.05, -0.02, 0.04, 0.4, 0.2, -0.1, 0.05, -0.1, 0.9])
    p = rng.normal(size=(c, m, 3)) * [0.05, 0.03, 0.0] + [0.02, 0.0, 0.3]
    T = flanges(rng, 1, m)
    mount = pose(BRACKET @ from_angles(*truth[1:4], order=order), truth[4:7])
    T_base_target = pose(from_angles(*truth[10:]), truth[7:10])
    scaled = mount.copy()
    scaled[:3, :3] *= truth[0]
    known = apply(inverse(T_base_target), apply(T, apply(scaled, p)))
    one = np.ones((c, m, 1))
    loops = Loops.of(np.concatenate([known, one], -1), np.concatenate([p, one], -1), T[..., :3, :3], T[..., :3, 3])
    lower, upper = around(truth[1:], 0.2)
    room = placement.Room(BRACKET, order, lower, upper, (lower + upper) / 2 + 0.05)
    found = placement.place(loops, room, np.tile([0.5, 2.0], (c, 1)))
    np.testing.assert_allclose(found[:, 0], truth[0], rtol=1e-6)
    np.testing.assert_allclose(found[:, 4:10], np.tile(truth[4:10], (c, 1)), atol=1e-6)


def test_a_tracker_and_its_reflectors_are_found_from_anywhere(rng: np.random.Generator) -> None:
    c, m = 5, 24
    T = flanges(rng, c, m)
    tool = np.arange(m) % 2
    tools = rng.normal(0, 0.1, (2, 3))
    base = pose(exp_so3(rng.normal(0, 2.0, (c, 3))), rng.normal(0, 2.0, (c, 3)))
    y = apply(base[:, None], apply(T, tools[tool]))
    chi = np.concatenate([y, np.ones((c, m, 1))], axis=-1)
    loops = Loops.of(chi, np.eye(2)[tool][None], T[..., :3, :3], T[..., :3, 3])
    end = np.array([*[np.pi] * 3, *[np.inf] * 9])
    found = tracker.follow(loops, tracker.Room(-end, end))
    np.testing.assert_allclose(found[:, 6:], np.tile(tools.ravel(), (c, 1)), atol=1e-8)
    np.testing.assert_allclose(found[:, 3:6], base[:, :3, 3], atol=1e-8)
    tight = np.concatenate([end[:3], end[3:6], np.full(6, 0.01)])
    bounded = tracker.follow(loops, tracker.Room(-tight, tight))
    assert (np.abs(bounded[:, 6:]) <= 0.01).all()

    def left(x: Array, i: int) -> Array:
        world = pose(from_angles(*x[:3]), x[3:6])
        return (apply(world, apply(T[i], x[6:].reshape(2, 3)[tool])) - y[i]).ravel()

    for i in range(c):
        far = np.array([*[10.0] * 6, *[0.01] * 6])
        theirs = least_squares(
            left, bounded[i], args=(i,), bounds=(-far - 1e-12, far + 1e-12), xtol=1e-15, ftol=1e-15, gtol=1e-15
        )
        assert (left(bounded[i], i) ** 2).sum() <= 2 * theirs.cost * (1 + 1e-9)


def test_a_ball_and_its_sockets_are_linear_least_squares(rng: np.random.Generator) -> None:
    c, m = 3, 30
    T = flanges(rng, c, m)
    R, t = T[..., :3, :3], T[..., :3, 3]
    socket = np.arange(m) % 3
    A = np.zeros((m, 3, 12))
    for i in range(m):
        A[i, :, 3 + 3 * socket[i] : 6 + 3 * socket[i]] = np.eye(3)
    for end in (np.inf, 0.05):
        ball, sockets = seats.seat(R, t, socket, np.full(12, -end), np.full(12, end))
        for i in range(c):
            A[:, :, :3] = -R[i]
            theirs = least_squares(
                lambda x, i=i: A.reshape(-1, 12) @ x - t[i].ravel(),
                np.zeros(12),
                jac=lambda x: A.reshape(-1, 12),
                bounds=(-end, end),
                xtol=1e-15,
                ftol=1e-15,
                gtol=1e-15,
                max_nfev=500,
            )
            np.testing.assert_allclose(np.concatenate([ball[i], sockets[i].ravel()]), theirs.x, atol=1e-6)
