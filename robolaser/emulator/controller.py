"""The far end of an arm's line: it receives bytes, answers, reports unasked, and turns motors."""

from abc import ABC, abstractmethod
from enum import Enum
from typing import ClassVar

from robolaser.arrays import Array


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

    @abstractmethod
    def receive(self, data: bytes, now_s: float) -> bytes:
        """Take what came over the line, and give what it answers at once."""

    @abstractmethod
    def poll(self, now_s: float) -> bytes:
        """What is due by now without being asked."""

    @abstractmethod
    def motor(self, now_s: float) -> Array:
        """Joint angles as the encoders see them, (j,) [rad] or [m]."""

    @abstractmethod
    def outputs(self, now_s: float) -> frozenset[int]:
        """The digital outputs that are on."""

    @abstractmethod
    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Let a fault happen; axes count from 1."""
