"""What small motions of a pose do to its points."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import exp_so3, pose, skew
from robolaser.model.error_source import along_each_axis


def rigid_moves(points: Array, of_pose: Ints) -> tuple[Array, Array]:
    """Moves of points (m, 3) [m] by shifts and turns of their pose about the middle of its points, (m, 3, 3) each."""
    arms = points - pose_centroids(points, of_pose, int(of_pose.max()) + 1)[of_pose]
    return along_each_axis(len(points), 3), skew(arms)


def pose_centroids(points: Array, of_pose: Ints, poses: int) -> Array:
    """The mean of each pose's points (m, 3), (poses, 3)."""
    sums = np.stack([np.bincount(of_pose, points[:, axis], minlength=poses) for axis in range(3)], axis=-1)
    mean: Array = sums / np.bincount(of_pose, minlength=poses).clip(min=1)[:, None]
    return mean


def twisted(T_base_flange: Array, twist: Array, pivot: Array) -> Array:
    """Poses (1, n, 4, 4) moved by a shift and a turn (6,) in the base frame, turned about pivots (n, 3)."""
    R = exp_so3(twist[3:])
    return pose(R, pivot + twist[:3] - pivot @ R.T)[None] @ T_base_flange
