"""What a linearization says is what residuals near it do, and what refits and repeated noise show."""

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.estimation.identifiability import UNIFORM
from robolaser.estimation.linearization import TALL, Linearization, triangle
from robolaser.estimation.noise_estimate import noise_of
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5, point_m=2e-5, joint_rad=1e-5)


def problem_of(kind, **more):
    dataset = simulate(find_robot("scorbot_er7"), kind=kind, poses=24, noise=NOISE, seed=3, **more).dataset
    model = Model(dataset)
    start = solve(Problem.of(model), model.parameters.nominal[None]).x[0]
    return Problem.of(model, noise_of(model, start), prior=UNIFORM * model.parameters.width), start


@pytest.fixture(scope="module", params=["stripe", "point", "pose", "profile", "socket"])
def fitted(request):
    problem, start = problem_of(request.param)
    return Linearization(problem, solve(problem, start[None]).x[0])


def test_derivatives_are_those_of_whitened_and_extra_rows(fitted):
    problem, x = fitted.problem, fitted.x
    step = 1e-6 * problem.scale * fitted.free

    def rows(x):
        return np.concatenate([problem.residuals(x), problem.extra_residuals(x)], axis=1)

    expected = (rows(x + np.diag(step)) - rows(x - np.diag(step))).T / 2e-6
    np.testing.assert_allclose(fitted.J, expected, rtol=1e-4, atol=1e-6 * np.abs(expected).max())


def test_at_the_optimum_no_parameter_can_lower_the_residuals(fitted):
    assert np.linalg.norm(fitted.J.T @ fitted.r) < 1e-5 * np.linalg.norm(fitted.J) * np.linalg.norm(fitted.r)
    assert fitted.cost == pytest.approx(fitted.r @ fitted.r)


def test_the_step_leads_back_to_the_optimum(fitted):
    away = fitted.x + 1e-6 * fitted.problem.scale * fitted.free
    there = Linearization(fitted.problem, away)
    apart = np.abs((away + there.step(there.r)) - fitted.x) / np.sqrt(np.diag(fitted.covariance) + 1e-30)
    assert apart[fitted.free].max() < 1e-2


def test_what_is_projected_no_parameter_can_imitate(fitted):
    rest = fitted.project(np.random.default_rng(1).normal(size=(len(fitted.white), 3)))
    np.testing.assert_allclose(fitted.J.T @ rest, 0.0, atol=1e-8 * np.linalg.norm(fitted.J))


def test_columns_of_an_effect_are_its_derivatives_for_every_value_of_its_nonlinear_parameters():
    problem, start = problem_of("point")
    (effect,) = candidate_effects(["transmission_error:joint_2"], problem.model.dataset)
    grid = np.array([[40.0], [77.0]])
    columns = Linearization(problem, start).columns(effect, grid)
    model = problem.model.with_effects((effect,))
    for shape, found in zip(grid, columns, strict=True):
        plain = np.concatenate([start, np.zeros(found.shape[1]), shape])
        for i in range(found.shape[1]):
            step = np.zeros(len(plain))
            step[len(start) + i] = 1e-5
            both = problem.whitened(model.residuals(np.stack([plain + step, plain - step])))
            np.testing.assert_allclose(
                found[:, i], (both[0] - both[1]) / 2e-5, rtol=1e-3, atol=1e-3 * np.abs(found).max()
            )


def test_the_covariance_is_that_of_repeated_noise():
    problem, _ = problem_of("point")
    at = Linearization(problem, solve(problem, problem.parameters.nominal[None]).x[0])
    rng, found = np.random.default_rng(7), []
    for e in rng.normal(size=(400, len(at.white))):
        found.append(at.step(np.concatenate([e, np.zeros(len(at.r) - len(e))])))
    scale = np.sqrt(np.diag(at.covariance))
    np.testing.assert_allclose(np.std(found, axis=0) / scale, 1.0, atol=0.15)


def test_parameters_pushed_against_a_bound_do_not_move():
    problem, start = problem_of("point")
    tight = problem.upper.copy()
    tight[0] = start[0] - 1e-3
    at = Linearization(problem, np.minimum(start, tight))
    at.problem.__dict__["upper"] = tight
    assert at.pushed[0]
    assert not at.free[0]
    assert np.all(at.J[:, 0] == 0.0)
    assert at.release.shape[1] == 1


@pytest.mark.parametrize("rows", [1, 3, 4, TALL, 3 * TALL + 5])
def test_an_r_factor_is_as_long_in_every_direction_as_all_the_rows(rows):
    rng = np.random.default_rng(rows)
    A, p = rng.normal(size=(rows, 4)) * 10.0 ** np.arange(-6, 6, 3), rng.normal(size=(4, 50))
    A[:, 2] += A[:, 1]
    R = triangle(A[rows // 2 :], triangle(A[: rows // 2]))
    assert len(R) == min(rows, 4)
    p = p / 10.0 ** np.arange(-6, 6, 3)[:, None]
    np.testing.assert_allclose(np.linalg.norm(R @ p, axis=0), np.linalg.norm(A @ p, axis=0), rtol=1e-12)
