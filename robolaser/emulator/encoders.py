"""What an ACL controller knows of its axes: the parameters that turn encoder counts into angles, and back."""

from collections.abc import Sequence
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.robot.kinematics import Robot

QUARTER = 33
"""PAR 33, 34, ...: counts of axis 1, 2, ... for 90 degrees (or a metre's quarter turn: a rail's pi/2 m)."""
REFERENCE = 52
"""PAR 52, 53, ...: counts of axis 1, 2, ... at the reference posture."""
LENGTHS = 92
"""PAR 92 to 97: lengths of the arm [0.1 mm]."""
OTHERS = {261: 10}
"""As the guide prints it (p. 3-104)."""
COUNTS = (23040, -23040, 23040, -19200, 23040)
"""For 90 degrees, and over again for more axes: 256 a degree, some encoders mounted the other way round."""
HOME = (0.5, 0.35, 0.65, 0.5, 0.5)
"""Where between its limits each axis has its home switch."""
UNLIMITED = np.pi
"""Range of an axis without limits to either side of zero [rad]."""


@final
class Encoders:
    """Counts of all axes. They are zero at home; before homing, zero is where the power came on.

    Args:
        robot: The arm.
        reference: Joint angles at the reference posture, (j,) [rad]; empty: all zero.
        direction: +1 or -1 for each joint; empty: all +1.
        decoupled: Whether its motors all sit in the base, as those of an ER V plus.
    """

    def __init__(
        self, robot: Robot, reference: Sequence[float], direction: Sequence[float], *, decoupled: bool = False
    ) -> None:
        j = len(robot.joints)
        self.lower = np.where(np.isfinite(robot.lower), robot.lower, -UNLIMITED)
        self.upper = np.where(np.isfinite(robot.upper), robot.upper, UNLIMITED)
        self.home = self.lower + np.resize(HOME, j) * (self.upper - self.lower)
        self._reference = np.array(reference or [0.0] * j)
        self._direction = np.array(direction or [1.0] * j)
        self._quarter = np.resize(COUNTS, j)
        self._decoupled = decoupled
        self._at_reference = np.zeros(j)
        self._at_reference = -np.rint(self._true(self.home))
        joints = robot.joint_frames(self.home[None, None])[0, 0, :, :3, 3]
        flange = robot.forward(self.home[None, None])[0, 0, :3, 3]
        lengths = np.linalg.norm(np.diff([*joints, flange], axis=0), axis=1)[:6]
        self.par: dict[int, int] = {
            **{QUARTER + i: int(counts) for i, counts in enumerate(self._quarter)},
            **{REFERENCE + i: int(counts) for i, counts in enumerate(self._at_reference)},
            **{LENGTHS + i: round(length * 1e4) for i, length in enumerate(lengths)},
            **OTHERS,
        }
        self._shift = np.zeros(j)

    def counts(self, q: Array) -> Ints:
        """What the counters show at joint angles, (j,) -> (j,)."""
        counts: Ints = np.rint(self._true(q) - self._shift).astype(np.int64)
        return counts

    def angles(self, counts: Ints) -> Array:
        """Joint angles at which the counters show this, (j,) -> (j,) [rad]."""
        turned = counts + self._shift - self._at_reference
        if self._decoupled:
            pitch, roll = (turned[3] - turned[4]) / 2, (turned[3] + turned[4]) / 2
            turned = np.array([*turned[:3], pitch, roll])
        turned = turned * (np.pi / 2) / self._quarter
        if self._decoupled:
            _, shoulder, forearm, hand, _ = turned.tolist()
            turned[2:4] = forearm - shoulder, hand - forearm
        q: Array = self._reference + self._direction * turned
        return q

    def lose(self, q: Array) -> None:
        """Come on anew: count from zero here."""
        self._shift = np.rint(self._true(q))

    def find_home(self) -> None:
        """Count from home again."""
        self._shift = np.zeros_like(self._shift)

    def outside(self, q: Array) -> list[int]:
        """Axes, from 1, that these joint angles would drive beyond their limits by a count or more."""
        slack = (np.pi / 2) / np.abs(self._quarter)
        return [int(i) + 1 for i in np.flatnonzero((q < self.lower - slack) | (q > self.upper + slack))]

    def _true(self, q: Array) -> Array:
        turned = self._direction * (q - self._reference)
        if self._decoupled:  # belts keep a link's direction in the world while the links before it turn
            turned[1:4] = np.cumsum(turned[1:4])
        motors = turned * self._quarter / (np.pi / 2)
        if self._decoupled:  # the hand's bevel gears: both motors turn for pitch and for roll
            pitch, roll = motors[3:]
            motors[3:] = roll + pitch, roll - pitch
        true: Array = self._at_reference + motors
        return true
