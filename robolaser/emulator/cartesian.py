"""Where an ACL controller says that its flange is: X Y Z [0.1 mm], pitch and roll [0.1 deg]."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.robot.kinematics import Robot

NAMES = "XYZPR"
TENTHS = np.array([1e4, 1e4, 1e4, 1800 / np.pi, 1800 / np.pi])
"""Units of X Y Z P R in a metre or a radian."""


def place(robot: Robot, q: Array) -> Ints:
    """X Y Z P R at joint angles, (j,) -> (5,)."""
    where: Ints = np.rint(_place(robot, q) * TENTHS).astype(np.int64)
    return where


def _place(robot: Robot, q: Array) -> Array:
    T = robot.forward(q[None, None])[0, 0]
    (x, y, z), ahead, thumb = T[:3, 3], T[:3, 2], T[:3, 0]
    turned = np.arctan2(y, x)
    side = np.array([-np.sin(turned), np.cos(turned), 0.0])
    pitch = np.arctan2(ahead[2], np.hypot(ahead[0], ahead[1]))
    roll = np.arctan2(thumb @ np.cross(ahead, side), thumb @ side)
    return np.array([x, y, z, pitch, roll])
