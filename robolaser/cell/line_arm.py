"""Arms on a serial line, and those whose servos share it, each with an address and an absolute encoder."""

from typing import ClassVar, Self

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.cell.failures import joints_differ
from robolaser.cell.serial_line import SerialLine
from robolaser.data.cell_config import ArmLine, Cell
from robolaser.robot.kinematics import Robot


class LineArm(Arm):
    """angle = reference_rad + direction (what the controller counts, as an angle)."""

    most: ClassVar[int]
    """How many joints can share the line."""

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        self._line, self._joints = line, robot.joints
        count = len(self._joints)
        if not 0 < count <= self.most:
            raise joints_differ(arm.kind, count, self.most)
        self._reference = np.array(arm.reference_rad or [0.0] * count)
        self._direction = np.array(arm.direction or [1.0] * count)

    @classmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Open the port and begin its protocol; where that fails, the port is closed again.

        Raises:
            ArmError: It cannot be opened, or does not lead to this robot's controller.
            DataError: The robot has more joints than can share the line.
        """
        line = SerialLine.open(cell.arm, clock)
        try:
            return cls(line, cell.arm, cell.robot)
        except BaseException:
            line.close()
            raise

    def close(self) -> None:
        """Close the port."""
        self._line.close()


class BusArm(LineArm):
    """Servos with absolute encoders, and no output."""

    outputs: ClassVar[int | None] = 0
    absolute_encoders: ClassVar[bool] = True
    counted_rad: ClassVar[float]
    """What one count of a servo, from its middle, is [rad]."""

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        super().__init__(line, arm, robot)
        self._ids = arm.ids or tuple(range(1, len(self._joints) + 1))
        self.step = np.full(len(self._joints), self.counted_rad)

    def home(self) -> None:
        """Nothing: their encoders are absolute."""

    def _angles(self, counts: Ints) -> Array:
        return np.asarray(self._reference + self._direction * counts * self.counted_rad)

    def _counts(self, q: Array) -> Ints:
        return np.asarray(np.rint(self._direction * (q - self._reference) / self.counted_rad).astype(np.int64))
