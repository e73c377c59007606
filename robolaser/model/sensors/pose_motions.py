"""What small motions of a pose do to its points."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.duals import Dual
from robolaser.geometry.rigid_motion import skew
from robolaser.model.error_source import along_each_axis


def rigid_moves(points: Array, of_pose: Ints, numbers: int) -> tuple[Array, Array]:
    """Moves of rows by shifts and turns of their pose about the middle of its points, (m, numbers, 3) each.

    A row has three numbers, its point (m, 3) [m] less the predicted one, and may have three more, the turn between.
    """
    arms = points - pose_centroids(points, of_pose, int(of_pose.max()) + 1)[of_pose]
    if numbers == 3:
        return along_each_axis(len(points), 3), skew(arms)
    shifts, turns = np.zeros((2, len(points), numbers, 3))
    shifts[:, :3] = turns[:, 3:] = np.eye(3)
    turns[:, :3] = -skew(arms)
    return shifts, turns


def pose_centroids(points: Array, of_pose: Ints, poses: int) -> Array:
    """The mean of each pose's points (m, 3), (poses, 3)."""
    sums = np.stack([np.bincount(of_pose, points[:, axis], minlength=poses) for axis in range(3)], axis=-1)
    mean: Array = sums / np.bincount(of_pose, minlength=poses).clip(min=1)[:, None]
    return mean


def in_six_ways(T_base_flange: Array, pivot: Array, first: int = 0) -> Dual:
    """Poses (c or 1, n, 4, 4) that may be shifted along the base's axes, and turned about them at pivots (n or 1, 3).

    The six motions have numbers from the first on.
    """
    slopes = np.zeros((6, *T_base_flange.shape))
    slopes[:3, ..., :3, 3] = np.eye(3)[:, None, None]
    arms = T_base_flange[..., :3, :].copy()
    arms[..., 3] -= pivot
    slopes[3:, ..., :3, :] = skew(np.eye(3))[:, None, None] @ arms
    return Dual(T_base_flange, slopes, tuple(range(first, first + 6)))
