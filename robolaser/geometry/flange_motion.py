"""How the flange moves with the joints and with their placements: the geometric Jacobian of a serial arm.

Siciliano, Khatib 2016, Springer Handbook of Robotics, ch. 2.8.
"""

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.rigid_motion import inverse, skew


def moved_by_joints(robot: Robot, frames: Array, moves: Array) -> Array:
    """Motions of the flange by small motions of the joints.

    Args:
        robot: The arm.
        frames: Its `joint_frames`, (c, n, len(chain), 4, 4).
        moves: Of the joints, in q directions, (c or 1, q, n, j) [rad or m].

    Returns:
        What is added to T_base_flange, to first order, (c, q, n, 4, 4).
    """
    T = frames[:, :, -1] @ robot.end
    out = np.zeros((max(len(frames), len(moves)), moves.shape[1], *T.shape[1:]))
    for k, i in enumerate(robot.chain):
        along = moves[..., i]
        which = along.any(axis=(0, 2))
        if not which.any():
            continue
        axis = frames[:, :, k, :3, :3] @ robot.axes[i]
        by_joint = np.zeros_like(T)
        if robot.prismatic[i]:
            by_joint[..., :3, 3] = axis
        else:
            turn = skew(axis)
            by_joint[..., :3, :] = turn @ T[..., :3, :]
            by_joint[..., :3, 3] -= (turn @ frames[:, :, k, :3, 3, None])[..., 0]
        out[:, which] += along[:, which, :, None, None] * by_joint[:, None]
    return out


def moved_by_placements(robot: Robot, frames: Array, placements: Array, moves: Array) -> Array:
    """Motions of the flange by small motions of the joints' placements.

    Args:
        robot: The arm.
        frames: Its `joint_frames`, (c, n, len(chain), 4, 4).
        placements: Of the joints, (c or 1, n or 1, j, 4, 4).
        moves: What is added to them in q directions, (c or 1, q, n or 1, j, 4, 4).

    Returns:
        What is added to T_base_flange, to first order, (c, q, n, 4, 4).
    """
    T = frames[:, :, -1] @ robot.end
    out = np.zeros((max(len(frames), len(moves)), moves.shape[1], *T.shape[1:]))
    for k, i in enumerate(robot.chain):
        which = moves[:, :, :, i].any(axis=(0, 2, 3, 4))
        if not which.any():
            continue
        onward = inverse(placements[:, :, i])
        before = moves[:, :, :, i][:, which] @ onward[:, None]
        if k:
            before = frames[:, None, :, k - 1] @ before
            onward = inverse(frames[:, :, k - 1]) @ T
        else:
            onward = T
        out[:, which] += before @ onward[:, None]
    return out
