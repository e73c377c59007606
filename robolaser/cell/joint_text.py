"""Joint values as people read them."""

import numpy as np

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot


def joint_text(robot: Robot, joint: int, value: float) -> str:
    """One joint's value, in degrees, or in millimetres for a rail."""
    return f"{1000 * value:.2f} mm" if robot.prismatic[joint] else f"{np.rad2deg(value):.2f}°"


def configuration_text(robot: Robot, q: Array) -> str:
    """All joints' values, (j,)."""
    return ", ".join(f"{joint} {joint_text(robot, i, float(q[i]))}" for i, joint in enumerate(robot.joints))


def at_worst(robot: Robot, off: Array, *postures: Array) -> tuple[str, ...]:
    """Name of the joint that is off the most, (j,), and its value in each of some postures, (j,) each."""
    joint = int(np.argmax(off))
    return robot.joints[joint], *(joint_text(robot, joint, float(q[joint])) for q in postures)
