"""Rows that no model and no noise accounts for: gross errors, found while the model itself may still be wrong."""

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.diagnosis.penalized_fit import Fit
from robolaser.diagnosis.thresholds import OUTLIER_SIGMA
from robolaser.model.noise import NoiseModel
from robolaser.model.noise.whitening import group_sums

ROUNDS = 8
"""Reweightings, after which the same rows count."""
TAIL = 2.5
"""Cauchy's constant, in robust standard deviations: 95 % as sure as least squares where all is normal."""
MEDIAN_NORM = 1.37
"""Median length of a row's whitened residual where noise alone made it: two pixels make three coordinates."""
LEAST_POINTS = 4
"""Points in a pose, from which on a free motion of the pose leaves something to see gross errors by."""
SHIFT_M, TURN_RAD = 0.02, 0.05
"""How far a pose may be off as a whole: what the model lacks moves whole poses, gross errors single rows."""


def robust_fit(fitted: Fit) -> Fit:
    """Fit again, rows far off counting little."""
    for _ in range(ROUNDS):
        norm = _norms(fitted.residuals, fitted.problem.noise)
        scale = max(1.0, float(np.median(norm)) / MEDIAN_NORM)
        weight = np.repeat((1.0 + (norm / (TAIL * scale)) ** 2) ** -0.5, 3)
        before, fitted = fitted, fitted.problem.fit(fitted.x, weight=weight, steps=ROUNDS)
        if np.allclose(fitted.x, before.x, rtol=0, atol=1e-4 * fitted.problem.prior.max()):
            break
    return fitted


def outliers_within_poses(fitted: Fit) -> Bools:
    """Mark rows far from where the others of their pose would have them, (m,).

    Each pose may be off as a whole by a free small motion, found robustly: so a robot that is not where the model has
    it hides no gross error and makes none.

    Args:
        fitted: A model of the rows as they were taken, fitted robustly.
    """
    model = fitted.problem.model
    of_pose = model.dataset.points.pose
    values = fitted.problem.parameters.values(fitted.x[None])
    root = _roots(fitted.problem.noise)
    r = (root @ fitted.residuals[..., None])[..., 0]
    enough = np.bincount(of_pose, minlength=len(model.dataset.poses)) >= LEAST_POINTS
    if not enough.any():
        return outliers_of(fitted)
    perturb = model.perturb(values)
    shifts, turns = model.sensor.moved_with_pose(values, model.flange(values, perturb), perturb)
    moves = np.concatenate([shifts * SHIFT_M, turns * TURN_RAD], axis=-1)
    B = root @ moves * enough[of_pose, None, None]
    left = r
    for _ in range(ROUNDS):
        norm = np.linalg.norm(left, axis=-1)
        scale = _scale(norm)
        weight = 1.0 / (1.0 + (norm / (TAIL * scale)) ** 2)
        A = group_sums(weight[:, None, None] * np.swapaxes(B, 1, 2) @ B, of_pose) + scale**2 * np.eye(6)
        b = group_sums(weight[:, None] * (np.swapaxes(B, 1, 2) @ r[..., None])[..., 0], of_pose)
        move = np.linalg.solve(A, b[..., None])[..., 0]
        left = r - (B @ move[of_pose][..., None])[..., 0]
    norm = np.linalg.norm(left, axis=-1)
    return np.asarray(norm > OUTLIER_SIGMA * _scale(norm))


def outliers_of(fitted: Fit) -> Bools:
    """Mark rows that a model which explains the others leaves far off, (m,)."""
    norm = _norms(fitted.residuals, fitted.problem.noise)
    return norm > OUTLIER_SIGMA * _scale(norm)


def _scale(norm: Array) -> float:
    return max(1.0, float(np.median(norm)) / MEDIAN_NORM)


def _norms(plain: Array, noise: NoiseModel) -> Array:
    norm: Array = np.linalg.norm((_roots(noise) @ plain[..., None])[..., 0], axis=-1)
    return norm


def _roots(noise: NoiseModel) -> Array:
    root: Array = np.linalg.inv(np.linalg.cholesky(noise.covariances))
    return root
