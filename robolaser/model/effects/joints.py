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
    return _with_one(q, column, q[:, :, column] + move)


def placed_anew(placements: Array, run: Run, joint: str, placement: Array) -> Array:
    """Placements of the joints (c or 1, n or 1, j, 4, 4) with another one (c, n or 1, 4, 4) of one joint.

    It is computed from the old one, so it has at least their derivatives.
    """
    return _with_one(placements, joint_column(run, joint), placement)


def _with_one(values: Array, column: int, own: Array) -> Array:
    moved: Array = np.zeros_like(own, shape=(*own.shape[:2], *values.shape[2:]))
    moved[:, :, column] = own
    for others in (slice(column), slice(column + 1, None)):
        moved[:, :, others] = values[:, :, others]
    return moved
