"""Where an ACL controller says that its flange is: X Y Z [0.1 mm], pitch and roll [0.1 deg]."""

from itertools import product

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.robot.kinematics import Robot

NAMES = "XYZPR"
TENTHS = np.array([1e4, 1e4, 1e4, 1800 / np.pi, 1800 / np.pi])
"""Units of X Y Z P R in a metre or a radian."""
NEAR = 1.0
"""How many units a solution may be off."""


def place(robot: Robot, q: Array) -> Ints:
    """X Y Z P R at joint angles, (j,) -> (5,)."""
    where: Ints = np.rint(_place(robot, q) * TENTHS).astype(np.int64)
    return where


def reach(robot: Robot, wanted: Ints, near: Array, lower: Array, upper: Array) -> Array | None:
    """Joint angles, (j,) [rad], within (j,) limits, for X Y Z P R, (5,); None: out of reach. Looks near (j,) first."""
    from scipy.optimize import least_squares  # noqa: PLC0415 - who never asks must not wait for it

    def miss(q: Array) -> Array:
        off: Array = _place(robot, q) - wanted / TENTHS
        off[3:] = np.sin(off[3:] / 2)
        return off

    for turn in product((0.0, 0.5), repeat=2):
        begin = np.clip(near, lower + 1e-6, upper - 1e-6)
        begin[1:3] += np.array(turn) * ((lower + upper) / 2 - begin)[1:3]
        found = least_squares(miss, begin, bounds=(lower, upper), xtol=1e-10, max_nfev=60).x
        if np.all(np.abs(miss(found)) * TENTHS < NEAR):
            return np.asarray(found)
    return None


def _place(robot: Robot, q: Array) -> Array:
    T = robot.forward(q[None, None])[0, 0]
    (x, y, z), ahead, thumb = T[:3, 3], T[:3, 2], T[:3, 0]
    turned = np.arctan2(y, x)
    side = np.array([-np.sin(turned), np.cos(turned), 0.0])
    pitch = np.arctan2(ahead[2], np.hypot(ahead[0], ahead[1]))
    roll = np.arctan2(thumb @ np.cross(ahead, side), thumb @ side)
    return np.array([x, y, z, pitch, roll])
