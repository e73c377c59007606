"""Velocities of joints, or of a flange: recorded, or from the path of an arm measured in motion."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset, Poses
from robolaser.geometry.rigid_motion import inverse, log_so3

LONGEST_STEP_S = 1.0
"""Largest time between poses of an arm in motion: such recordings have several poses a second; where an arm stops to
be measured, poses are seconds apart."""
ROUGHEST = 0.3
"""Distance of poses from the line between their neighbours, over half the way between these, RMS: for poses in any
order it is above 1, of a sine read six times a period 0.5, ten times a period 0.3."""
LEAST_SHARE = 0.9  # least share of poses with neighbours within LONGEST_STEP_S
WARNING = (
    "poses.csv has no velocities: they are taken from the path by finite differences, since its poses follow one"
    ' another in motion. Where the arm did stop at each pose, set path = "unknown" in [robot].'
)


def with_path_velocities(dataset: Dataset) -> Dataset:
    """The data set with velocities by finite differences along its path, and a warning.

    They are NaN at poses without two others close in time: the velocity there is unknown. Unchanged where velocities
    were recorded, where times or path are not known, or where poses are too far apart in time or way: then the arm may
    have stopped at each.
    """
    poses = dataset.poses
    if poses.qd is not None or poses.time_s is None or dataset.time_is_order or not dataset.path_known:
        return dataset
    if poses.q is None and poses.T_base_flange is None:
        return dataset
    numbers = 6 if poses.q is None else poses.q.shape[1]
    qd, count, rough, way = np.full((len(poses), numbers), np.nan), 0, 0.0, 0.0
    for run in _runs(dataset, poses.time_s):
        ahead, back = _ways(poses, run)
        step = np.diff(poses.time_s[run])[:, None]
        share = step[:-1] / (step[:-1] + step[1:])
        leaving, arriving = ahead / step, back / step
        first = leaving[:1] - share[:1] * (leaving[1:2] - leaving[:1])
        last = arriving[-1:] + (1.0 - share[-1:]) * (arriving[-1:] - arriving[-2:-1])
        qd[run] = np.concatenate([first, share * leaving[1:] + (1.0 - share) * arriving[:-1], last])
        count += len(run)
        rough += float(np.square((1.0 - share) * back[:-1] - share * ahead[1:]).sum())
        way += float(np.square(0.5 * (ahead[1:] + back[:-1])).sum())
    if count < LEAST_SHARE * len(poses) or not way > 0.0 or rough > ROUGHEST**2 * way:
        return dataset
    return replace(dataset, poses=replace(poses, qd=qd, qd_from_path=True), warnings=(*dataset.warnings, WARNING))


def _ways(poses: Poses, run: Ints) -> tuple[Array, Array]:
    """Motions from each pose of a run to the next, in the frames of the first and of the second, (k - 1, j) each."""
    if poses.q is not None:
        return (along := np.diff(poses.q[run], axis=0)), along
    assert poses.T_base_flange is not None  # one of the two is there
    T = poses.T_base_flange[run]
    return _twist(inverse(T[:-1]) @ T[1:]), -_twist(inverse(T[1:]) @ T[:-1])


def _twist(T: Array) -> Array:
    """Translation and turn vector of small motions (..., 4, 4), (..., 6) [m, rad]."""
    return np.concatenate([T[..., :3, 3], log_so3(T[..., :3, :3])], axis=-1)


def without_velocity(dataset: Dataset) -> Ints:
    """Numbers of the poses with points at which the arm's velocity is not known, though at others it is."""
    seen = np.unique(dataset.points.pose)
    return seen[:0] if dataset.poses.qd is None else seen[np.isnan(dataset.poses.qd[seen]).any(axis=1)]


def known_velocities(dataset: Dataset) -> Array | None:
    """Velocities at the exposures, (n, j), see `Poses.qd`; None where a pose with points lacks its own.

    They are 0 where they are unknown and there are no points.
    """
    qd = dataset.poses.qd
    return None if qd is None or len(without_velocity(dataset)) else np.nan_to_num(qd)


def _runs(dataset: Dataset, time_s: Array) -> Iterator[Ints]:
    """Numbers of poses that followed one another closely, three at least, within a session."""
    for path in dataset.paths:
        step = np.diff(time_s[path])
        apart = (step > LONGEST_STEP_S) | (step <= 0.0)
        yield from (run for run in np.split(path, np.flatnonzero(apart) + 1) if len(run) > 2)
