"""The step is the best that the bounds allow, as SciPy finds it too."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from robolaser.estimation.bounded_step import bounded_steps

DAMPINGS = np.array([1e-12, 1e-6, 1e-2, 1.0, 1e4])


def problem(seed, k=30, d=8):
    rng = np.random.default_rng(seed)
    J, r = rng.standard_normal((k, d)) * 10.0 ** rng.uniform(-2, 2, d), rng.standard_normal(k)
    lower, upper = -rng.exponential(0.02, d), rng.exponential(0.02, d)
    lower[rng.random(d) < 0.2] = 0.0
    upper[rng.random(d) < 0.2] = 0.0
    lower[rng.random(d) < 0.2] = -np.inf
    return J, r, lower, upper


def damped_steps(J, r, lower, upper):
    """Steps for all dampings at once, and by how much each lowers |J p + r|² + damping |p|²."""
    c, d = len(DAMPINGS), J.shape[1]
    A = J.T @ J + (DAMPINGS * np.linalg.norm(J, 2) ** 2)[:, None, None] * np.eye(d)
    return bounded_steps(A, np.tile(J.T @ r, (c, 1)), np.tile(lower, (c, 1)), np.tile(upper, (c, 1)))[:2]


@pytest.mark.parametrize("seed", range(25))
def test_the_step_is_the_optimum_of_the_bounded_model(seed):
    J, r, lower, upper = problem(seed)
    steps, gains = damped_steps(J, r, lower, upper)
    room = upper > lower
    for step, gain, damping in zip(steps, gains, DAMPINGS * np.linalg.norm(J, 2) ** 2, strict=True):
        A = np.vstack([J, np.sqrt(damping) * np.eye(len(step))])[:, room]
        best = lsq_linear(A, np.append(-r, np.zeros(len(step))), (lower[room], upper[room]), method="bvls", tol=1e-14)
        ours = np.sum((J @ step + r) ** 2) + damping * np.sum(step**2)
        assert np.all((step >= lower) & (step <= upper))
        assert ours <= 2.0 * best.cost * (1.0 + 1e-10)
        assert gain == pytest.approx(r @ r - ours, abs=1e-10 * (r @ r))


def test_more_damping_makes_shorter_steps():
    J, r, _, _ = problem(2)
    steps, gains = damped_steps(J, r, np.full(8, -np.inf), np.full(8, np.inf))
    assert np.all(np.diff(np.linalg.norm(steps, axis=1)) < 0)
    assert np.all(np.diff(gains) < 0)


@pytest.mark.parametrize("seed", range(10))
def test_without_full_rank_the_step_still_keeps_to_the_bounds(seed):
    J, r, lower, upper = problem(seed, k=4, d=12)
    steps, gains = damped_steps(J, r, lower, upper)
    assert np.all((steps >= lower) & (steps <= upper))
    assert gains.max() >= 0.0
