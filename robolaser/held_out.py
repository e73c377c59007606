"""How well a calibration predicts poses that it has not seen."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.box import Box, Residuals
from robolaser.dataset import Dataset

FOLDS = 10
FEWEST = 3  # poses with points; below, what is left fits anything
TOLERANCE = 1e-6  # of a fold's polish: along a bent valley, where it stops, predictions hardly change


def held_out(residuals: Residuals, x: Array, box: Box, *, seed: int) -> tuple[Array | None, int]:
    """Leave groups of poses out in turn, fit the rest, and predict them.

    Every pose with points is left out once, whole, never a single row: rows of a pose share their errors. Each fit
    starts from the parameters found on all poses.

    Args:
        residuals: Those that were minimised.
        x: The parameters found, (d,).
        box: Where the polish may go.
        seed: Deals the poses into groups.

    Returns:
        Known or measured points less predicted ones, (m, 3) [m], or None with too few poses; and the candidates
        evaluated.
    """
    model = residuals.model
    groups = fold_of_rows(model.dataset, seed)
    if groups is None:
        return None, 0
    errors = np.empty((len(groups), 3))
    evaluations = 0
    for group in np.unique(groups):
        out = groups == group
        kept = np.repeat(~out, 3)
        end = box.polish(lambda X, kept=kept: residuals(X)[:, kept], x, tol=TOLERANCE)  # type: ignore[misc]
        errors[out] = model.residuals(end.x[None])[0, out]
        evaluations += end.evaluations
    return (errors if np.isfinite(errors).all() else None), evaluations


def fold_of_rows(dataset: Dataset, seed: int) -> Ints | None:
    """The group in which each row is left out, (m,); None with too few poses.

    Poses are dealt in turn from each socket, or each set of reflectors, so that none is left out altogether.
    """
    points = dataset.points
    seen = np.unique(points.pose)
    if len(seen) < FEWEST:
        return None
    shuffled = np.random.default_rng(seed).permutation(seen)
    if dataset.kind == "socket":
        socket = {int(pose): name for pose, name in zip(points.pose, points.names, strict=True)}
        shuffled = np.array(sorted(shuffled, key=lambda pose: socket[int(pose)]))
    group_of_pose = np.full(len(dataset.poses), -1)
    group_of_pose[shuffled] = dealt(len(shuffled))
    return group_of_pose[points.pose].astype(np.int64)


def dealt(count: int) -> Ints:
    """The group that each of so many poses gets when they are dealt in turn, (count,)."""
    return np.arange(count, dtype=np.int64) % min(FOLDS, count)
