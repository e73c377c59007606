"""The fit of all rows: by plain squares, or again and again with weights and a loss that rest on what it left over."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.subsampling import rows_of_each
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_loss import Loss
from robolaser.estimation.sample_fit import gradients, sampled, solve_corrected
from robolaser.estimation.solver import TOLERANCE, solve
from robolaser.model.forward_model import Model
from robolaser.model.noise import comparable, noise_of
from robolaser.model.pose_blocks import with_rows

ROUNDS = 3  # weights depend on the estimate; a fourth round changes nothing any more

FEWER, CROWD = 20_000, 4
"""Rows to fit first where there are so many times more: from there on the steps on all rows are few."""
COARSE = 1e-9  # tolerance of that
PASSES = 3  # over all rows, before the solver takes them: what is left to go then is below its tolerance, or nearly so
CROWDED = 1e-11
"""Tolerance on so many rows: a million of them put the optimum a hundredth of a standard error from there."""


def fit(model: Model, start: Array, *, weights: str = "plain", loss: str = "square") -> tuple[Problem, Array, int]:
    """Fit all rows from a good start.

    Args:
        model: All rows.
        start: (d,).
        weights: "plain", which weighs rows alike, and numbers of two units within them by their sizes; or "noise" to
            whiten by the covariance of the noise.
        loss: "square", or one that lets gross errors count for less, by a scale from the residuals.

    Returns:
        The problem that was solved last, its optimum (d,), and the residual vectors evaluated.

    Raises:
        UsageError: There is no loss of that name.
    """
    Loss(loss)
    plain = comparable(model, start)
    problem = Problem.of(model, plain)
    evaluations = 0
    if problem.rows > CROWD * FEWER:
        start, evaluations = _by_sample(problem, start)
    end = solve(problem, start[None], tol=TOLERANCE if problem.rows <= CROWD * FEWER else CROWDED)
    evaluations += end.evaluations
    for _ in range(ROUNDS if model.known_distances is not None else 0):
        problem = problem.with_rows_of_size(end.x[0])
        end = solve(problem, end.x)
        evaluations += end.evaluations
    for _ in range(ROUNDS if weights == "noise" or loss != "square" else 0):
        x = end.x[0]
        noise = noise_of(model, x, problem.inliers(x)).for_weights() if weights == "noise" else plain
        white = problem.with_noise(noise)
        problem = problem.with_noise(noise, Loss.fitting(loss, white.residuals(x[None])[0], problem.starts))
        problem = problem.with_rows_of_size(x)
        end = solve(problem, end.x)
        evaluations += end.evaluations
    return problem, end.x[0], evaluations


def _by_sample(problem: Problem, start: Array) -> tuple[Array, int]:
    """A start close to the optimum of all rows (d,), by fits of some of them, and the residual vectors evaluated."""
    found = sampled(problem, FEWER)
    if found is None:
        of_pose = problem.model.dataset.points.pose
        rows = rows_of_each(of_pose, max(1, FEWER // len(np.unique(of_pose))))
        end = solve(Problem.of(with_rows(problem.model, rows)), start[None], tol=COARSE)
        return end.x[0], end.evaluations
    sample, _ = found
    end = solve(sample, start[None], tol=COARSE)
    evaluations = end.evaluations
    for _ in range(PASSES):
        gradient = gradients(problem, end.x[0])[0] / problem.rows
        end = solve_corrected(sample, end.x[0], gradient)
        evaluations += end.evaluations + len(start) + 1
    return end.x[0], evaluations


def outlier_warnings(problem: Problem, x: Array) -> list[str]:
    """A warning where the loss lets rows count for less than a half."""
    doubted = int(np.count_nonzero(~problem.inliers(x)))
    if not doubted:
        return []
    return [
        f"{doubted} of {problem.rows} points lie so far off that they count for less than half "
        f"({problem.loss.name} loss)."
    ]
