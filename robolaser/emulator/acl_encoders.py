"""Encoder counts of a SCORBOT, and its controller's listings of them."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.cell_config import Cell

QUARTER = 33  # PAR 33, 34, ...: counts of axis 1, 2, ... for 90 degrees (or a metre's quarter turn: a rail's pi/2 m)
REFERENCE = 52  # PAR 52, 53, ...: counts of axis 1, 2, ... at the reference posture
COUNTS = (23040, -23040, 23040, -19200, 23040)  # for 90 degrees, in turn: 256 per degree, some encoders reversed
HOME = (0.5, 0.35, 0.65, 0.5, 0.5)  # position of each axis's home switch between its limits
UNLIMITED = np.pi  # range of an axis without limits to either side of zero [rad]
TENTHS = {"X": 1e4, "Y": 1e4, "Z": 1e4, "P": 1800 / np.pi, "R": 1800 / np.pi}
"""Units of the flange's position, and of its pitch and roll, per metre or radian."""
WIDTH = 9  # of a number in a listing, with its sign, or a blank for plus


@final
class AclEncoders:
    """Counts of all axes: zero at home; before homing, zero where the power came on."""

    def __init__(self, cell: Cell) -> None:
        self._robot = robot = cell.robot
        j = len(robot.joints)
        self.lower = np.where(np.isfinite(robot.lower), robot.lower, -UNLIMITED)
        self.upper = np.where(np.isfinite(robot.upper), robot.upper, UNLIMITED)
        self.home = self.lower + np.resize(HOME, j) * (self.upper - self.lower)
        self._reference = np.array(cell.arm.reference_rad or [0.0] * j)
        self._direction = np.array(cell.arm.direction or [1.0] * j)
        quarter = np.resize(COUNTS, j)
        self._slack = (np.pi / 2) / np.abs(quarter)
        self._per_radian = np.diag(quarter / (np.pi / 2))
        if cell.arm.axes == "er5plus":
            self._per_radian = _hand_gears() @ self._per_radian @ _belts()
        self._at_reference, self._shift = np.zeros(j), np.zeros(j)
        self._at_reference = -np.rint(self._true(self.home))
        self.par: dict[int, int] = {
            **{QUARTER + i: int(counts) for i, counts in enumerate(quarter)},
            **{REFERENCE + i: int(counts) for i, counts in enumerate(self._at_reference)},
        }

    def counts(self, q: Array) -> Ints:
        """Counts at joint angles, (j,) -> (j,)."""
        return np.asarray(np.rint(self._true(q) - self._shift).astype(np.int64))

    def angles(self, counts: Ints) -> Array:
        """Joint angles of counts, (j,) -> (j,) [rad]."""
        turned = np.linalg.solve(self._per_radian, counts + self._shift - self._at_reference)
        return np.asarray(self._reference + self._direction * turned)

    def lose(self, q: Array) -> None:
        """Restart: count from zero here."""
        self._shift = np.rint(self._true(q))

    def find_home(self) -> None:
        """Count from home again."""
        self._shift = np.zeros_like(self._shift)

    def outside(self, q: Array) -> list[int]:
        """Axes, from 1, that these joint angles would drive beyond their limits by a count or more."""
        beyond = (q < self.lower - self._slack) | (q > self.upper + self._slack)
        return [int(i) + 1 for i in np.flatnonzero(beyond)]

    def listed(self, counts: Ints) -> tuple[str, ...]:
        """A controller's listing of counts, (j,), and of the flange's pose there."""
        T = self._robot.forward(self.angles(counts)[None, None])[0, 0]
        (x, y, z), ahead, thumb = T[:3, 3], T[:3, 2], T[:3, 0]
        side = np.array([-y, x, 0.0]) / max(np.hypot(x, y), 1e-9)
        pitch = np.arctan2(ahead[2], np.hypot(ahead[0], ahead[1]))
        roll = np.arctan2(thumb @ np.cross(ahead, side), thumb @ side)
        pose = zip(TENTHS, (x, y, z, pitch, roll), strict=True)
        lines = [
            [f"{axis}:{count:< {WIDTH}d}" for axis, count in enumerate(counts, 1)],
            [f"{name}:{round(TENTHS[name] * value):< {WIDTH}d}" for name, value in pose],
        ]
        return tuple("".join(line).rstrip() for line in lines)

    def _true(self, q: Array) -> Array:
        """Counts from home, before they are rounded, (j,)."""
        return np.asarray(self._at_reference + self._per_radian @ (self._direction * (q - self._reference)))


def _belts() -> Array:
    """From turns of the joints of an ER V plus to those of its motors, all in the base: links keep their directions."""
    belts = np.eye(5)
    belts[1:4, 1:4] = np.tril(np.ones((3, 3)))
    return belts


def _hand_gears() -> Array:
    """The hand's bevel gears, by counts: both motors turn for pitch and for roll."""
    gears = np.eye(5)
    gears[3:, 3:] = [[1.0, 1.0], [-1.0, 1.0]]
    return gears
