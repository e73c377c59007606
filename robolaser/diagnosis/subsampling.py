"""Which rows of a large data set a diagnosis works with: more of them would say nothing new, only later."""

import numpy as np

from robolaser.arrays import Bools
from robolaser.data.dataset import Dataset, Points

MOST_POSES = 300
"""Poses with rows that are kept: an effect that needs more to be seen is far below what matters."""
MOST_ROWS = 4000
"""Rows that are kept, as long as each pose has a few: rows of a pose share most of their errors."""
FEWEST_ROWS = 3
"""Of each pose: the reflectors of a tracker, or enough to tell a stripe's shift from its tilt."""


def chosen_rows(points: Points) -> Bools:
    """Mark some rows, evenly along those of each pose, of poses chosen by chance, the same each time, (m,)."""
    poses = np.unique(points.pose)
    if len(poses) > MOST_POSES:
        poses = np.sort(np.random.default_rng(0).choice(poses, MOST_POSES, replace=False))
    most = max(FEWEST_ROWS, MOST_ROWS // max(1, len(poses)))
    order = np.argsort(points.pose, kind="stable")
    starts, counts = np.searchsorted(points.pose[order], poses), np.bincount(points.pose)[poses]
    kept = np.zeros(len(points), dtype=bool)
    for start, count in zip(starts, counts, strict=True):
        kept[order[start + np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))]] = True
    return kept


def kept_poses(dataset: Dataset) -> Bools:
    """Mark poses with rows, and those at the ends of time and of what else was measured, (n,)."""
    poses = dataset.poses
    kept = np.bincount(dataset.points.pose, minlength=len(poses)) > 0
    measured = list(poses.coordinates.values())
    if poses.time_s is not None:
        measured.append(poses.time_s)
    for values in measured:
        kept[[int(np.argmin(values)), int(np.argmax(values))]] = True
    return kept
