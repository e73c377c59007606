"""Encoders that do not say what the joint does: zeros, gains, discs off their axis, gears that run unevenly."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.physics.effect import Departure, shifted
from robolaser.trials.worlds.arm import Arm


@final
@dataclass(frozen=True)
class Zero(Departure):
    """The zero is off by `size` [rad]."""

    name: ClassVar[str] = "joint_offset"

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """Farther."""
        return shifted(q, column, self.size)


@final
@dataclass(frozen=True)
class Gain(Departure):
    """The joint goes farther than it reads, by the share `size`."""

    name: ClassVar[str] = "encoder_scale"

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """Farther from zero."""
        return shifted(q, column, self.size * float(q[column]))


@final
@dataclass(frozen=True)
class OffCentre(Departure):
    """A disc whose middle is off the axis by the share `size` of its radius, towards the angle `towards` [rad]."""

    name: ClassVar[str] = "encoder_eccentricity"

    towards: float = 0.0

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """The angle at the axis of what the head reads beside it."""
        angle = float(q[column]) - self.towards
        beside = np.arctan2(self.size * np.sin(angle), 1.0 - self.size * np.cos(angle))
        return shifted(q, column, float(beside))


@final
@dataclass(frozen=True)
class Uneven(Departure):
    """A gear whose error, `size` [rad] at most, comes back `cycles` times a turn of the joint."""

    name: ClassVar[str] = "transmission_error"

    cycles: float = 8.0
    phase: float = 0.0

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """Now ahead, now behind."""
        return shifted(q, column, self.size * float(np.sin(self.cycles * q[column] + self.phase)))
