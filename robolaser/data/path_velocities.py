"""Joint velocities: as recorded, or from the path of an arm that is measured while it moves."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset

LONGEST_STEP_S = 1.0
"""Between poses of an arm in motion: recordings in motion are read several times a second, and where an arm stops to be
measured, poses are seconds apart."""
ROUGHEST = 0.3
"""Distance of poses from the line between their neighbours, over half the way between these, root mean squares: of
places visited in any order it is above 1, of a sine read six times a period 0.5, ten times a period 0.3."""
LEAST_SHARE = 0.9  # of the poses, that must have neighbours so near
WARNING = (
    "poses.csv has no joint velocities: they are taken from the path by finite differences, since its poses follow one"
    ' another in motion. Where the arm did stop at each pose, set path = "unknown" in [robot].'
)


def with_path_velocities(dataset: Dataset) -> Dataset:
    """The data set with velocities by finite differences along its path, and a warning that says so.

    They are NaN at poses that no two others are close to in time: how fast the arm moved there nobody knows.
    Unchanged where velocities were recorded, where times or path are not known, or where poses are too far apart in
    time or way: then the arm may have stopped at each.
    """
    poses, robot = dataset.poses, dataset.robot
    if robot is None or poses.q is None or poses.qd is not None or poses.time_s is None:
        return dataset
    if dataset.time_is_order or not dataset.path_known:
        return dataset
    qd, told, rough, way = np.full_like(poses.q, np.nan), 0, 0.0, 0.0
    for run in _runs(dataset, poses.time_s):
        t, q = poses.time_s[run], poses.q[run]
        qd[run] = np.gradient(q, t, axis=0)
        told += len(run)
        share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
        rough += float(np.square(q[1:-1] - (1.0 - share) * q[:-2] - share * q[2:]).sum())
        way += float(np.square(0.5 * (q[2:] - q[:-2])).sum())
    if told < LEAST_SHARE * len(poses) or not way > 0.0 or rough > ROUGHEST**2 * way:
        return dataset
    return replace(dataset, poses=replace(poses, qd=qd, qd_from_path=True), warnings=(*dataset.warnings, WARNING))


def without_velocity(dataset: Dataset) -> Ints:
    """Numbers of the poses with points at which the arm's velocity is not known, though at others it is."""
    seen = np.unique(dataset.points.pose)
    return seen[:0] if dataset.poses.qd is None else seen[np.isnan(dataset.poses.qd[seen]).any(axis=1)]


def known_velocities(dataset: Dataset) -> Array | None:
    """Joint velocities at the exposures, (n, j) [rad/s or m/s]; None where a pose with points lacks its own.

    They are 0 where nothing was seen and nobody knows.
    """
    qd = dataset.poses.qd
    return None if qd is None or len(without_velocity(dataset)) else np.nan_to_num(qd)


def _runs(dataset: Dataset, time_s: Array) -> Iterator[Ints]:
    """Numbers of poses that followed one another closely, three at least, within a session."""
    session = dataset.session_of_pose
    order = np.lexsort((time_s, session)).astype(np.int64)
    step = np.diff(time_s[order])
    apart = (step > LONGEST_STEP_S) | (step <= 0.0) | (np.diff(session[order]) != 0)
    yield from (run for run in np.split(order, np.flatnonzero(apart) + 1) if len(run) > 2)
