"""Which rows of a large data set a diagnosis works with: more of them would say nothing new, only later."""

import numpy as np

from robolaser.arrays import Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import some_of_each

MAX_POSES = 300
"""Poses with rows that are kept: an effect that needs more to be seen is far below what matters."""
MAX_ROWS = 4000
"""Rows that are kept, as long as each pose has a few: rows of a pose share most of their errors."""
MIN_ROWS = 3
"""Of each pose, where it has as many: enough to tell a stripe's shift from its tilt."""


def chosen_rows(dataset: Dataset) -> Bools:
    """Mark rows of poses chosen by chance, the same each time, (m,).

    Where names mean the same point at every pose, with one row in each, whole poses are kept, some of each name; else
    rows evenly taken along those of each pose.
    """
    points, named = dataset.points, dataset.format.named_points and not dataset.format.many_rows
    poses, first = np.unique(points.pose, return_index=True)
    chosen = _some(poses, points.number[first] if named else np.zeros(len(poses), dtype=np.int64))
    kept = np.zeros(len(points), dtype=bool)
    of_sensors = dataset.rows_of_sensors
    for of_sensor, has_names in of_sensors:
        rows = of_sensor[np.isin(points.pose[of_sensor], chosen)]
        if not has_names and len(rows):
            table = some_of_each(points.pose[rows], max(MIN_ROWS, MAX_ROWS // len(of_sensors) // len(chosen)))
            rows = rows[table[table >= 0]]
        kept[rows] = True
    return kept


def _some(poses: Ints, group: Ints) -> Ints:
    """At most about `MAX_POSES` of the poses, by chance, as many of each group."""
    if len(poses) <= MAX_POSES:
        return poses
    rng, groups = np.random.default_rng(0), np.unique(group)
    each = max(1, MAX_POSES // len(groups))
    of_groups = [poses[group == number] for number in groups]
    return np.sort(np.concatenate([rng.choice(own, min(each, len(own)), replace=False) for own in of_groups]))


def kept_poses(dataset: Dataset) -> Bools:
    """Mark poses with rows, and those at the ends of time and of what else was measured, (n,)."""
    poses = dataset.poses
    kept = np.bincount(dataset.points.pose, minlength=len(poses)) > 0
    measured = list(poses.coordinates.values())
    if poses.time_s is not None:
        measured.append(poses.time_s)
    session = dataset.session_of_pose
    for poses_of in (np.flatnonzero(session == number) for number in np.unique(session)):
        for values in measured:
            kept[poses_of[[int(np.argmin(values[poses_of])), int(np.argmax(values[poses_of]))]]] = True
    return kept
