"""Rows that no model and no noise accounts for: gross errors, found while the model itself may still be wrong."""

import numpy as np
from scipy.special import chdtri

from robolaser.arrays import Array, Bools, Ints
from robolaser.diagnosis.fit import SHARE, TOLERANCE, Fit
from robolaser.diagnosis.thresholds import (
    FREE_POSE_M,
    FREE_POSE_ROWS,
    LEVER_M,
    MIN_POSES,
    MOST_POSES_OFF,
    OUTLIER_SIGMA,
)
from robolaser.estimation.robust_loss import EFFICIENT, Loss
from robolaser.estimation.solver import solve
from robolaser.model.blocks.errors import moved_with_pose
from robolaser.model.noise.whitening import group_sums

FITS = 4
"""Robust fits, each with the scale that the last one left: then the same rows count."""
ROUNDS = 8
"""Reweightings of the free motion of a pose."""
TAIL = EFFICIENT["cauchy"]
"""Scale of Cauchy's loss, in standard deviations."""
UNUSED = 0.5
"""Numbers of a row that its errors do not fill on average: two pixels make the three coordinates of a stripe's row."""


def robust_fit(fit: Fit) -> Fit:
    """Fit again, rows far off counting little."""
    x = fit.x
    for _ in range(FITS):
        problem = fit.problem
        loss = Loss.fitting("cauchy", problem.residuals(x[None])[0], problem.starts)
        problem = problem.with_noise(fit.noise, Loss("cauchy", max(loss.scale, TAIL)))
        x = solve(problem, x[None], tol=SHARE, enough=TOLERANCE).x[0]
    return Fit(fit.problem, x)


def outliers_within_poses(fit: Fit) -> Bools:
    """Mark rows far from where the others of their pose would have them, (m,).

    Each pose may be off as a whole by a free small motion, found robustly: so a robot that is not where the model has
    it hides no gross error and makes none.

    Args:
        fit: A model of the rows as they were taken, fitted robustly.
    """
    model = fit.model
    of_pose = model.dataset.points.pose
    values = fit.problem.parameters.values(fit.x[None])
    root = _roots(fit)
    r = (root @ fit.at.plain[..., None])[..., 0]
    enough = np.bincount(of_pose, minlength=len(model.dataset.poses)) >= FREE_POSE_ROWS
    if not enough.any():
        return outliers_of(fit)
    perturb = model.perturb(values)
    shifts, turns = moved_with_pose(model.blocks, values, model.flange(values, perturb), perturb)
    moves = FREE_POSE_M * np.concatenate([shifts, turns / LEVER_M], axis=-1)
    B = root @ moves * enough[of_pose, None, None]
    left = r
    for _ in range(ROUNDS):
        scale = _scale(left)
        weight = 1.0 / (1.0 + (np.linalg.norm(left, axis=-1) / (TAIL * scale)) ** 2)
        A = group_sums(weight[:, None, None] * np.swapaxes(B, 1, 2) @ B, of_pose) + scale**2 * np.eye(6)
        b = group_sums(weight[:, None] * (np.swapaxes(B, 1, 2) @ r[..., None])[..., 0], of_pose)
        move = np.linalg.solve(A, b[..., None])[..., 0]
        left = r - (B @ move[of_pose][..., None])[..., 0]
    return _far(left, of_pose)


def outliers_of(fit: Fit) -> Bools:
    """Mark rows that a model which explains the others leaves far off, (m,); none of fewer poses than tell a model."""
    if len(fit.poses) < MIN_POSES:
        return np.zeros(len(fit.model.dataset.points), dtype=bool)
    return _far((_roots(fit) @ fit.at.plain[..., None])[..., 0], fit.model.dataset.points.pose)


def _far(rows: Array, of_pose: Ints) -> Bools:
    """Rows (m, k) that are far off; but if at many poses most are, the arm or the base stood elsewhere then."""
    far = np.asarray(np.linalg.norm(rows, axis=-1) > OUTLIER_SIGMA * _scale(rows))
    taken = np.bincount(of_pose)
    off = 2 * np.bincount(of_pose, far) >= np.maximum(taken, 1)
    many = np.count_nonzero(off) > MOST_POSES_OFF * np.count_nonzero(taken)
    return far & ~off[of_pose] if many else far


def _scale(rows: Array) -> float:
    """Standard deviation of white rows (m, k) by their median length, at least 1: gross errors do not move it."""
    numbers = max(1.0, rows.shape[1] - UNUSED)
    return max(1.0, float(np.median(np.linalg.norm(rows, axis=-1)) / np.sqrt(chdtri(numbers, 0.5))))


def _roots(fit: Fit) -> Array:
    """Whitens each row by itself, (m, k, k) [1/unit]."""
    root: Array = np.linalg.inv(np.linalg.cholesky(fit.noise.covariances))
    return root
