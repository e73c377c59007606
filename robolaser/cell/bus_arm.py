"""Arms of servos that share a line, each with an address and an absolute encoder, and none with an output."""

from typing import ClassVar, Self

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.cell.failures import joints_differ
from robolaser.cell.serial_line import SerialLine, connect
from robolaser.data.cell_config import ArmLine, Cell
from robolaser.robot.kinematics import Robot


class BusArm(Arm):
    """angle = reference_rad + direction (what a servo counts from its middle) counted_rad."""

    outputs: ClassVar[int | None] = 0
    absolute_encoders: ClassVar[bool] = True
    counted_rad: ClassVar[float]
    """What one count of a servo is [rad]."""
    most: ClassVar[int]
    """How many servos can share the line."""

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        self._joints = robot.joints
        if not 0 < len(self._joints) <= self.most:
            raise joints_differ(arm.kind, len(self._joints), self.most)
        self._line = line
        self._ids = arm.ids or tuple(range(1, len(self._joints) + 1))
        self._reference = np.array(arm.reference_rad or [0.0] * len(self._joints))
        self._direction = np.array(arm.direction or [1.0] * len(self._joints))
        self.step = np.full(len(self._joints), self.counted_rad)

    @classmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Open the port and see that every servo answers.

        Raises:
            ArmError: It cannot be opened.
        """
        return connect(lambda line: cls(line, cell.arm, cell.robot), cell.arm, clock)

    def home(self) -> None:
        """Nothing: their encoders are absolute."""

    def close(self) -> None:
        """Close it."""
        self._line.close()

    def _angles(self, counts: Ints) -> Array:
        angles: Array = self._reference + self._direction * counts * self.counted_rad
        return angles

    def _counts(self, q: Array) -> Ints:
        counts: Ints = np.rint(self._direction * (q - self._reference) / self.counted_rad).astype(np.int64)
        return counts
