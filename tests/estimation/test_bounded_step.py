"""The step is the best that the bounds allow, as SciPy finds it too."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from robolaser.estimation.bounded_step import Linear

DAMPINGS = np.array([0.0, 1e-6, 1e-2, 1.0, 1e4])


def problem(seed, k=30, d=8):
    rng = np.random.default_rng(seed)
    J, r = rng.standard_normal((k, d)) * 10.0 ** rng.uniform(-2, 2, d), rng.standard_normal(k)
    lower, upper = -rng.exponential(0.02, d), rng.exponential(0.02, d)
    lower[rng.random(d) < 0.2] = 0.0
    upper[rng.random(d) < 0.2] = 0.0
    lower[rng.random(d) < 0.2] = -np.inf
    return J, r, lower, upper


@pytest.mark.parametrize("seed", range(25))
def test_the_step_is_the_optimum_of_the_bounded_model(seed):
    J, r, lower, upper = problem(seed)
    steps, gains = Linear(J, 1e-12).steps(r, lower, upper, DAMPINGS)
    room = upper > lower
    for step, gain, damping in zip(steps, gains, DAMPINGS * np.linalg.norm(J, 2) ** 2, strict=True):
        A = np.vstack([J, np.sqrt(damping) * np.eye(len(step))])[:, room]
        best = lsq_linear(A, np.append(-r, np.zeros(len(step))), (lower[room], upper[room]), method="bvls", tol=1e-14)
        ours = np.sum((J @ step + r) ** 2) + damping * np.sum(step**2)
        assert np.all((step >= lower) & (step <= upper))
        assert ours <= 2.0 * best.cost * (1.0 + 1e-10)
        assert gain == pytest.approx(r @ r - np.sum((J @ step + r) ** 2), abs=1e-10 * (r @ r))


def test_along_what_cannot_be_seen_there_is_no_step():
    J, r, _, _ = problem(1)
    J[:, 3] = J[:, 2]
    steps, _ = Linear(J, 1e-12).steps(r, np.full(8, -np.inf), np.full(8, np.inf), DAMPINGS)
    np.testing.assert_allclose(steps[:, 3], steps[:, 2], rtol=1e-6)
    shortest = -np.linalg.pinv(J, rcond=1e-12) @ r
    np.testing.assert_allclose(steps[0], shortest, rtol=1e-6)


def test_more_damping_makes_shorter_steps():
    J, r, _, _ = problem(2)
    steps, gains = Linear(J, 1e-12).steps(r, np.full(8, -np.inf), np.full(8, np.inf), DAMPINGS)
    assert np.all(np.diff(np.linalg.norm(steps, axis=1)) < 0)
    assert np.all(np.diff(gains) < 0)


@pytest.mark.parametrize("seed", range(10))
def test_without_full_rank_the_step_still_keeps_to_the_bounds(seed):
    J, r, lower, upper = problem(seed, k=4, d=12)
    steps, gains = Linear(J, 1e-12).steps(r, lower, upper, DAMPINGS)
    assert np.all((steps >= lower) & (steps <= upper))
    assert gains.max() >= 0.0


@pytest.mark.parametrize("seed", range(5))
def test_a_triangle_gives_the_steps_of_what_it_stands_for(seed):
    J, r, lower, upper = problem(seed)
    R = np.linalg.qr(np.column_stack([J, r]), mode="r")
    steps, gains = Linear(J, 1e-12).steps(r, lower, upper, DAMPINGS)
    same, as_much = Linear(R[:, :-1], 1e-12).steps(R[:, -1], lower, upper, DAMPINGS)
    np.testing.assert_allclose(same, steps, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(as_much, gains, rtol=1e-9, atol=1e-12)


def test_residuals_that_pull_as_asked_for_are_the_shortest():
    J, _, _, _ = problem(3)
    pulls = np.random.default_rng(3).standard_normal((4, 8))
    e = Linear(J, 1e-12).pulling(pulls)
    np.testing.assert_allclose(e @ J, pulls, rtol=1e-8)
    np.testing.assert_allclose(e, pulls @ np.linalg.pinv(J), rtol=1e-8, atol=1e-10)
