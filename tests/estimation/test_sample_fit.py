"""A sample of large data, corrected by the gradient of all rows, leads to the optimum of all rows."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.estimation.folds import assign_folds, held_out
from robolaser.estimation.noise_estimate import noise_of
from robolaser.estimation.plain_fit import fit, gradients, sampled, solve_corrected
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5)
MADE = simulate(find_robot("scorbot_er7"), poses=60, points=200, noise=NOISE, seed=1)


@pytest.fixture(scope="module")
def whole() -> tuple[Problem, np.ndarray, float]:
    problem = Problem.of(Model(MADE.dataset))
    end = solve(problem, np.array([[MADE.truth[name] for name in problem.parameters.names]]))
    return problem, end.x[0], float(end.cost[0])


def test_each_pass_brings_the_sample_much_closer_to_the_optimum_of_all_rows(whole) -> None:
    problem, _, least = whole
    sample, _ = sampled(problem, 1500)
    x = solve(sample, problem.parameters.nominal[None]).x
    above = [problem.costs(x)[0] / least - 1.0]
    for _ in range(2):
        x = solve_corrected(sample, x[0], gradients(problem, x[0])[0] / problem.rows).x
        above.append(problem.costs(x)[0] / least - 1.0)
    assert above[1] < 0.03 * above[0]
    assert above[2] < 0.03 * above[1] + 1e-12


def test_at_the_optimum_of_all_rows_the_corrected_sample_stays(whole) -> None:
    problem, x, _ = whole
    sample, _ = sampled(problem, 1500)
    end = solve_corrected(sample, x, gradients(problem, x)[0] / problem.rows)
    assert problem.costs(end.x)[0] == pytest.approx(problem.costs(x[None])[0], rel=1e-12)


def test_gradients_of_groups_add_up_to_that_of_all_rows(whole) -> None:
    problem, x, _ = whole
    x = x + 1e-3 * problem.scale * ~problem.fixed
    parts, all_rows = gradients(problem, x, problem.model.dataset.points.pose % 3), gradients(problem, x)[0]
    np.testing.assert_allclose(parts.sum(axis=0), all_rows, rtol=1e-9, atol=1e-12 * np.abs(all_rows).max())


def test_held_out_errors_of_large_data_are_those_of_fits_without_the_fold(whole) -> None:
    problem, x, _ = whole
    folds = assign_folds(problem.model, 1)
    errors = held_out(problem, x, folds).errors
    for fold in (0, 7):
        out = folds.of_row == fold
        there = problem.model.residuals(solve(problem, x[None], kept=~out[None]).x)[0, out]
        assert np.sqrt(((errors[out] - there) ** 2).mean() / (there**2).mean()) < 0.02


def test_a_crowd_of_rows_ends_at_their_optimum(whole, monkeypatch) -> None:
    monkeypatch.setattr("robolaser.estimation.plain_fit.FEWER", 2000)
    problem, _, least = whole
    _, x, _ = fit(problem.model, problem.parameters.nominal)
    assert problem.costs(x[None])[0] == pytest.approx(least, rel=1e-10)


def test_rows_that_share_errors_or_have_weights_are_not_sampled(whole) -> None:
    problem, x, _ = whole
    assert sampled(problem.with_noise(noise_of(problem.model, x)), 1500) is None
    assert sampled(replace(problem, prior=problem.scale), 1500) is None
    assert sampled(problem, problem.rows) is None
