"""What the encoders of SCORBOT arms count: joints one by one, or the directions of the links in the world."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import Axes

AXES = 5


def radians_per_count(axes: Axes, per_quarter: Array) -> Array:
    """Matrix from counts since the reference posture to joint angles since then, (j, j) [rad].

    The ER VII counts each joint by itself. The ER V plus is decoupled: all its motors sit in the base, so the elbow's
    encoder counts the forearm's angle in the world, and the hand's pitch in the world and its roll are half the
    difference and half the sum of encoders 4 and 5 (ACL reference guide for Controller-A, p. 7-10).

    Args:
        axes: Type of the arm.
        per_quarter: Counts of each axis for 90 degrees, PAR 33 to 37, (j,).
    """
    scaled = np.diag(np.pi / 2 / per_quarter)
    if axes == "er7":
        return scaled
    in_joints = np.eye(AXES) - np.diag([0.0, 1.0, 1.0, 0.0], -1)
    return in_joints @ scaled @ _differential()


def pitch_in_world(per_quarter: Array, counts: Array) -> float:
    """Pitch of an ER V plus's hand, by counts since the horizontal reference posture, (5,) [rad]."""
    return float((_differential() @ counts)[3] * np.pi / 2 / per_quarter[3])


def _differential() -> Array:
    """From counts of axes 1 to 5 to those of base, shoulder, elbow, pitch and roll, (5, 5)."""
    mixed = np.eye(AXES)
    mixed[3:, 3:] = [[0.5, -0.5], [0.5, 0.5]]
    return mixed
