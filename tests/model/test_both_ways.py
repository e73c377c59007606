"""The cost of a population that is compiled and its twin in NumPy are the same."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.compiled import threads
from robolaser.compiled.loops import SWITCH, Loops, compiles
from robolaser.data.dataset import Dataset, Noise
from robolaser.geometry.rigid_motion import apply, carry, exp_so3, pose
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

SEED = 3
RNG = np.random.default_rng(SEED)
CELLS = {
    "stripe": {"kind": "stripe"},
    "stripe along v": {"kind": "stripe", "stripe_axis": "v"},
}
pytestmark = pytest.mark.skipif(compiles() == "0", reason="there is no compiler")


@pytest.fixture(autouse=True)
def compiled_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SWITCH, "1")


@pytest.fixture(autouse=True)
def same_draws_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "RNG", np.random.default_rng(SEED))


@contextmanager
def without_compiler() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        yield


@pytest.fixture(scope="module", params=list(CELLS))
def dataset(request: pytest.FixtureRequest) -> Dataset:
    return simulate(find_robot("scorbot_er7"), poses=9, points=7, noise=Noise(), seed=2, **CELLS[request.param]).dataset


def candidates(model: Model, count: int = 6) -> Array:
    near = RNG.uniform(-0.05, 0.05, (count, len(model.parameters)))
    return model.parameters.nominal + near * model.parameters.width


def test_compiled_and_numpy_agree(dataset: Dataset) -> None:
    model = Model(dataset)
    x = candidates(model)
    J = model.cost(x)
    with without_compiler():
        np.testing.assert_allclose(J, Model(dataset).cost(x), rtol=1e-12)


@pytest.mark.parametrize("cell", [{"kind": "stripe", "placed": False}, {"kind": "stripe"}])
def test_residuals_are_never_compiled(cell: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    model = Model(simulate(find_robot("scorbot_er7"), poses=9, points=7, seed=2, **cell).dataset)
    monkeypatch.setattr(Loops, "after", lambda *_: pytest.fail("compiled loops were asked for"))
    assert np.isfinite(model.residuals(candidates(model))).all()


def test_rows_may_come_in_any_order() -> None:
    model = Model(simulate(find_robot("scorbot_er7"), poses=5, points=6, seed=1).dataset)
    order = RNG.permutation(len(model.dataset.points))
    mixed = Model(replace(model.dataset, points=model.dataset.points.take(order)))
    x = candidates(model)
    np.testing.assert_allclose(mixed.residuals(x), model.residuals(x)[:, order], rtol=0, atol=1e-14)
    np.testing.assert_allclose(mixed.cost(x), model.cost(x), rtol=1e-12)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_so_many_candidates_so_many_answers_however_many_rows(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    model = Model(simulate(find_robot("scorbot_er7"), poses=5, points=6, seed=1).dataset)
    x = candidates(model, 3)
    whole = model.residuals(x)
    monkeypatch.setattr("robolaser.model.forward_model.CHUNK", 7)
    np.testing.assert_array_equal(model.residuals(x[:count]), whole[:count])
    assert model.cost(x[:count]).shape == (count,)


def test_candidates_at_a_pole_cost_infinitely_much_and_spoil_no_other() -> None:
    model = Model(simulate(find_robot("scorbot_er7"), poses=5, points=6, seed=1).dataset)
    x = candidates(model, 3)
    where = model.parameters.columns(["k", "theta", "s_v", "v_0"])
    x[1, where] = 0.0, 0.0, 1.0, model.dataset.points.pixel[0, 1]  # type: ignore[index]
    assert np.isinf(model.cost(x)).tolist() == [False, True, False]


def test_threads_change_no_digit(monkeypatch: pytest.MonkeyPatch) -> None:
    model = Model(simulate(find_robot("scorbot_er7"), poses=60, points=50, seed=1).dataset)
    x = candidates(model, 64)
    costs = []
    for cores in (1, 3):
        monkeypatch.setattr(threads, "cores", lambda cores=cores: cores)
        costs.append(model.cost(x))
    np.testing.assert_array_equal(*costs)


def test_points_are_carried_by_the_frame_of_their_row() -> None:
    T = pose(exp_so3(RNG.normal(size=(2, 4, 3))), RNG.normal(size=(2, 4, 3)))
    of_row, points = RNG.integers(0, 4, 9), RNG.normal(size=(1, 9, 3))
    np.testing.assert_allclose(carry(T, of_row, points), apply(T[:, of_row], points), rtol=0, atol=1e-14)
