"""The far end of an arm's line: it receives bytes, answers, reports unasked, and turns motors."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import Enum
from typing import ClassVar

import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import Cell
from robolaser.emulator.joints import Axis


class ArmFault(Enum):
    """Faults of an arm."""

    IMPACT = "impact"
    """A link hits something: the controller notices and lets go."""
    STALL = "stall"
    """A gear jams: the motor stops, whatever it is told."""
    THERMIC = "thermic"
    """A motor is too hot: the controller switches it off."""
    HOMELESS = "homing"
    """A home switch is broken: this axis never finds its home."""
    REBOOT = "reboot"
    """The power was off for a moment."""


class Controller(ABC):
    """An arm's controller as a state machine; time is an argument and never runs backwards [s]."""

    command_mark: ClassVar[bytes] = b"\r"
    """What each command has once."""
    _axes: Sequence[Axis]

    @abstractmethod
    def receive(self, data: bytes, now_s: float) -> bytes:
        """Take what came over the line, and give what it answers at once."""

    def poll(self, now_s: float) -> bytes:
        """What is due by now without being asked."""
        return b""

    def motor(self, now_s: float) -> Array:
        """Joint angles as the encoders see them, (j,) [rad] or [m]."""
        return np.array([axis.at(now_s) for axis in self._axes])

    def outputs(self, now_s: float) -> frozenset[int]:
        """The digital outputs that are on."""
        return frozenset()

    @abstractmethod
    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Let a fault happen; axes count from 1."""


class ServoChain(Controller):
    """Servos that share a line, each with an address and an absolute encoder; they answer only when they are asked."""

    def __init__(self, cell: Cell) -> None:
        robot, arm = cell.robot, cell.arm
        count = len(robot.joints)
        self._ids = tuple(arm.ids or range(1, count + 1))
        self._reference = np.array(arm.reference_rad or [0.0] * count)
        self._direction = np.array(arm.direction or [1.0] * count)
        self._lower, self._upper = robot.lower, robot.upper
        self._axes = [Axis(float(q)) for q in np.clip(self._reference, robot.lower, robot.upper)]

    def _turned(self, i: int, angle: float) -> float:
        """How far a servo is turned from its middle at a joint angle [rad]."""
        return float(self._direction[i] * (angle - self._reference[i]))

    def _within_limits(self, i: int, turned: float) -> tuple[float, float]:
        """The joint angle nearest to where a servo is turned so far from its middle, and how far off that is [rad]."""
        wanted = float(self._reference[i] + self._direction[i] * turned)
        angle = float(np.clip(wanted, self._lower[i], self._upper[i]))
        return angle, abs(angle - wanted)
