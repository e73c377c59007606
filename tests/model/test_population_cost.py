"""Costs of populations: J as the residuals have it, for every candidate by itself."""

from dataclasses import replace

import numpy as np
import pytest
from asked import simulate_as_asked

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import apply, carry, exp_so3, pose
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

SEED = 3
RNG = np.random.default_rng(SEED)
CELLS = {"stripe": {"kind": "stripe"}, "stripe along v": {"kind": "stripe", "stripe_axis": "v"}}


@pytest.fixture(autouse=True)
def same_draws_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "RNG", np.random.default_rng(SEED))


@pytest.fixture(scope="module", params=list(CELLS))
def dataset(request: pytest.FixtureRequest) -> Dataset:
    return simulate_as_asked(
        find_robot("scorbot_er7"), poses=9, points=7, noise=Noise(), seed=2, **CELLS[request.param]
    ).dataset


def candidates(model: Model, count: int = 6) -> Array:
    near = RNG.uniform(-0.05, 0.05, (count, len(model.parameters)))
    return model.parameters.nominal + near * model.parameters.width


def test_a_populations_cost_is_the_sum_of_its_squared_residuals(dataset):
    model = Model(dataset)
    x = candidates(model)
    np.testing.assert_allclose(model.cost(x), np.square(model.residuals(x)).sum(axis=(1, 2)), rtol=1e-12)


@pytest.mark.parametrize("at_once", [1, 100, 10**9])
def test_how_many_candidates_are_evaluated_at_once_changes_no_digit(at_once, dataset, monkeypatch):
    model = Model(dataset)
    x = candidates(model, 20)
    J = model.cost(x)
    monkeypatch.setattr("robolaser.model.forward_model.CHUNK", at_once)
    np.testing.assert_array_equal(model.cost(x), J)


def test_rows_may_come_in_any_order():
    model = Model(simulate(find_robot("scorbot_er7"), poses=5, points=6, seed=1).dataset)
    order = RNG.permutation(len(model.dataset.points))
    mixed = Model(replace(model.dataset, points=model.dataset.points.take(order)))
    x = candidates(model)
    np.testing.assert_allclose(mixed.residuals(x), model.residuals(x)[:, order], rtol=0, atol=1e-14)
    np.testing.assert_allclose(mixed.cost(x), model.cost(x), rtol=1e-12)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_so_many_candidates_so_many_answers_however_many_rows(count, monkeypatch):
    model = Model(simulate(find_robot("scorbot_er7"), poses=5, points=6, seed=1).dataset)
    x = candidates(model, 3)
    whole = model.residuals(x)
    monkeypatch.setattr("robolaser.model.forward_model.CHUNK", 7)
    np.testing.assert_array_equal(model.residuals(x[:count]), whole[:count])
    assert model.cost(x[:count]).shape == (count,)


def test_candidates_at_a_pole_cost_infinitely_much_and_spoil_no_other():
    model = Model(simulate(find_robot("scorbot_er7"), poses=5, points=6, seed=1).dataset)
    x = candidates(model, 3)
    where = model.parameters.columns(["k", "theta", "s_v", "v_0"])
    x[1, where] = 0.0, 0.0, 1.0, model.dataset.points.pixel[0, 1]
    assert np.isinf(model.cost(x)).tolist() == [False, True, False]


def test_points_are_carried_by_the_frame_of_their_row():
    T = pose(exp_so3(RNG.normal(size=(2, 4, 3))), RNG.normal(size=(2, 4, 3)))
    of_row, points = RNG.integers(0, 4, 9), RNG.normal(size=(1, 9, 3))
    np.testing.assert_allclose(carry(T, of_row, points), apply(T[:, of_row], points), rtol=0, atol=1e-14)
