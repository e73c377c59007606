"""The joints of an arm that can have effects, and joint values or placements with one joint moved."""

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.run import Run
from robolaser.robot.kinematics import Robot


def moving_joints(robot: Robot | None) -> tuple[str, ...]:
    """The joints between base and flange, base first; none where flange poses were measured."""
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain)


def turning_joints(robot: Robot | None) -> tuple[str, ...]:
    """The revolute ones of them."""
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain if not robot.prismatic[i])


def joint_column(run: Run, joint: str) -> int:
    """The column of a joint in q."""
    return run.robot.joints.index(joint)


def add_to_joint(q: Array, run: Run, joint: str, move: Array) -> Array:
    """Joint values (c or 1, n, j) with one joint moved by (c, n or 1) [rad or m], (c, n, j)."""
    column = joint_column(run, joint)
    own = q[:, :, column] + move
    moved: Array = np.zeros_like(own, shape=(*own.shape, q.shape[2]))
    moved[:] = q
    moved[:, :, column] = own
    return moved


def placed_anew(placements: Array, run: Run, joint: str, placement: Array) -> Array:
    """Placements of the joints (c or 1, n or 1, j, 4, 4) with another one (c, n or 1, 4, 4) of one joint.

    It is computed from the old one, so it has at least their derivatives.
    """
    moved: Array = np.zeros_like(placement, shape=(*placement.shape[:2], *placements.shape[2:]))
    moved[:] = placements
    moved[:, :, joint_column(run, joint)] = placement
    return moved
