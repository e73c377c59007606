"""The fit of equally weighted rows, and fits of large data on a sample of their rows, corrected by all rows.

A sample determines the curvature; the exact optimum needs all rows. One pass over all rows gives the gradient at a
point. A constant added to the sample's residuals gives the sample's cost the same gradient there, and then the sample
is fitted. The excess cost of all rows above its optimum falls to about a thousandth, with 20 rows of each of 1000
poses: the better the sample's curvature agrees with that of all rows, the further.
"""

from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.subsampling import rows_of_each
from robolaser.estimation.linearization import RANK, triangle
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import TOLERANCE, Solution, solve
from robolaser.model.blocks.errors import row_errors
from robolaser.model.forward_model import Model, depends_on_trajectory, with_rows
from robolaser.model.noise.covariance import FLOOR, NoiseModel

ROUNDS = 3  # the size of rows depends on the estimate; a fourth round changes nothing
FEWER, CROWD = 20_000, 4  # rows to fit first where there are so many times more: then few steps on all rows remain
COARSE = 1e-9  # tolerance of that
PASSES = 3  # over all rows, before the solver takes them: the remaining decrease is then about its tolerance
CROWDED = 1e-11
"""Tolerance on so many rows: a million of them put the optimum a hundredth of a standard error from there."""


def fit(model: Model, start: Array) -> tuple[Problem, Array, int]:
    """Fit all rows from a good start (d,) with equal weights, numbers of two units within them by their sizes.

    Returns:
        The problem that was solved last, its optimum (d,), and the residual vectors evaluated.
    """
    plain = _comparable(model, start)
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


def _comparable(model: Model, x: Array) -> NoiseModel | None:
    """Weights of rows in two units by the size of each one's errors; None where all numbers of a row are lengths.

    They make metres and radians comparable in an unweighted fit. Sizes are stated, else the median of the residuals'
    numbers at x (d,), near the optimum.
    """
    if not any(angles for *_, angles in model.blocks.kinds_of_rows.values()):
        return None
    sources, residuals = row_errors(model.blocks, *model.at(x)), model.residuals(x[None])[0]
    sigmas = {}
    for source in sources:
        moved = (source.effect**2).sum(axis=(1, 2)) > 0.0  # others are another sensor's
        sigmas[source.name] = source.stated or max(size_of_errors(source.effect[moved], residuals[moved]), FLOOR)
    return NoiseModel(sources, sigmas, relative=True)


def size_of_errors(effect: Array, residuals: Array) -> float:
    """Median over rows (m, k) of the least unit errors that explain them, root mean square; 0 where there are no rows.

    Each of q unit errors moves the rows by `effect`, (m, k, q).
    """
    errors = (np.linalg.pinv(effect) @ residuals[..., None])[..., 0]
    sizes = np.linalg.norm(errors, axis=1) / np.sqrt(np.maximum(np.linalg.matrix_rank(effect), 1))
    return float(np.median(sizes)) if len(sizes) else 0.0


def sampled(problem: Problem, most: int) -> tuple[Problem, Ints] | None:
    """The problem of so many rows, evenly taken from all poses, and which they are, (most,).

    None where a sample cannot represent all: rows must count by their squares, and each depend on its pose alone.
    """
    rows = problem.rows
    alone = problem.noise is None and problem.prior is None and problem.model.known_distances is None
    if not alone or not problem.loss.is_square or depends_on_trajectory(problem.model) or rows <= most:
        return None
    stride = rows / most
    along = np.argsort(problem.model.dataset.points.pose, kind="stable")
    taken = np.sort(along[((np.arange(most) + 0.5) * stride).astype(np.int64)])
    return replace(problem, model=with_rows(problem.model, taken)), taken


def solve_corrected(
    sample: Problem, x: Array, gradient: Array, *, kept: Bools | None = None, tol: float = TOLERANCE
) -> Solution:
    """Fit a sample with the gradient of all rows.

    Args:
        sample: Some rows.
        x: Where the gradient was taken, (d,).
        gradient: Jᵀr of all rows over their number, by each parameter over its scale, (d,).
        kept: Rows of the sample that count, (m,); all when absent.
        tol: See `solve`.
    """
    counts = np.ones(sample.rows, dtype=bool) if kept is None else kept
    of_number = counts[sample.row_of_number]
    J = sample.jacobian(x[None])[0] * of_number
    lacking = np.count_nonzero(counts) * gradient - J @ sample.residuals(x[None])[0]
    _, s, Vt = np.linalg.svd(triangle(J.T), full_matrices=False)
    seen = s > RANK * s.max(initial=0.0)
    shift = ((Vt[seen] @ lacking) / s[seen] ** 2) @ Vt[seen] @ J
    corrected = replace(sample, shift=shift)
    if kept is None:
        return solve(corrected, x[None], tol=tol)
    enough = tol * float(corrected.costs(x[None])[0])
    return solve(corrected, x[None], kept=kept[None], tol=tol, enough=enough)


def gradients(problem: Problem, x: Array, groups: Ints | None = None) -> Array:
    """Jᵀr of each group of rows (m,), or of all, by each parameter over its scale, (g, d)."""
    count = 1 if groups is None else int(groups.max()) + 1
    total = np.zeros((count, len(x)))
    for rows, batch in problem.batches:
        r = batch.residuals(x[None])
        if groups is not None:
            r = r * (groups[rows][batch.row_of_number] == np.arange(count)[:, None])
        total += r @ batch.jacobian(x[None])[0].T
    return total
