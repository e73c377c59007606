"""How the flange moves with the joints and with their placements: the geometric Jacobian of a serial arm.

Siciliano, Khatib 2016, Springer Handbook of Robotics, ch. 2.8.
"""

from typing import Any, cast

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import bare, is_dual, joined
from robolaser.geometry.rigid_motion import inverse, skew
from robolaser.robot.kinematics import Robot


def moving_flange(robot: Robot, q: Array, placements: Array) -> Array:
    """T_base_flange, (c, n, 4, 4), with derivatives where joint values or placements carry some.

    Args:
        robot: The arm.
        q: Joint values, (c or 1, n, j) [rad or m].
        placements: Of the joints, (c or 1, n or 1, j, 4, 4).
    """
    angles, placed = cast("Any", q), cast("Any", placements)
    if not (is_dual(q) or is_dual(placements)):
        return robot.forward(q, placements)
    frames, by_joints = robot.joint_frames_and_twists(bare(q), bare(placements))
    T, twists = frames[:, :, -1] @ robot.end, []
    if is_dual(q):
        twists.append((angles.of, twists_by_joints(by_joints, angles.slopes.swapaxes(0, 1))))
    if is_dual(placements):
        by_links = twists_by_placements(robot, frames, placed.value, placed.slopes.swapaxes(0, 1))
        twists.append((placed.of, by_links))
    moved: Any = joined(T, [(of, moved_by_twists(T, each).swapaxes(0, 1)) for of, each in twists])
    return cast("Array", moved)


def twists_by_joints(twists: Array, moves: Array) -> Array:
    """Twists of the flange by small motions of the joints.

    Args:
        twists: Per unit of each joint, as of `Robot.joint_frames_and_twists`, (c, n, 6, j).
        moves: Of the joints, in q directions, (c or 1, q, n or 1, j) [rad or m].

    Returns:
        Shift of what is at the base's origin, and turn, in the base frame, (c, q, n, 6) [m, rad].
    """
    return np.moveaxis(twists @ np.moveaxis(moves, 1, -1), -1, 1)


def twists_by_placements(robot: Robot, frames: Array, placements: Array, moves: Array) -> Array:
    """Twists of the flange by small motions of the joints' placements.

    Args:
        robot: The arm.
        frames: Its `joint_frames`, (c, n, len(chain), 4, 4).
        placements: Of the joints, (c or 1, n or 1, j, 4, 4).
        moves: What is added to them in q directions, (c or 1, q, n or 1, j, 4, 4).

    Returns:
        As of `twists_by_joints`, (c, q, n, 6).
    """
    out = np.zeros((max(len(frames), len(moves)), moves.shape[1], frames.shape[1], 6))
    for k, i in enumerate(robot.chain):
        which = moves[:, :, :, i].any(axis=(0, 2, 3, 4))
        if not which.any():
            continue
        W = moves[:, :, :, i][:, which] @ inverse(placements[:, :, i])[:, None]
        shift, turn = W[..., :3, 3], np.stack([W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], axis=-1)
        if k:
            R, t = frames[:, None, :, k - 1, :3, :3], frames[:, None, :, k - 1, :3, 3]
            shift, turn = (R @ shift[..., None])[..., 0], (R @ turn[..., None])[..., 0]
            shift = shift + np.cross(t, turn)
        out[:, which, :, :3] += shift
        out[:, which, :, 3:] += turn
    return out


def moved_by_twists(T: Array, twists: Array) -> Array:
    """What is added to motions T (c, n, 4, 4), to first order, by twists in the base frame (c or 1, q, n or 1, 6)."""
    out = np.zeros((max(len(T), len(twists)), twists.shape[1], *T.shape[1:]))
    out[..., :3, :] = skew(twists[..., 3:]) @ T[:, None, :, :3]
    out[..., :3, 3] += twists[..., :3]
    return out
