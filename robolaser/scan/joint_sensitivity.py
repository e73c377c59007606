"""How far a point of the cell moves when a joint is misread."""

import numpy as np

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot


def joint_sensitivity(robot: Robot, q: Array, points: Array) -> Array:
    """Move of a point per unit of each joint of the chain, base first.

    Args:
        robot: The arm.
        q: Joint values, (n, j) [rad or m].
        points: In the base frame, one for each pose, (n, 3) [m].

    Returns:
        (n, len(chain)) [m/rad, or 1 for joints that slide].
    """
    moves = robot.jacobian(q[None], points[None])[0][:, :3, list(robot.chain)]
    return np.asarray(np.linalg.norm(moves, axis=1))
