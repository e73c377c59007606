"""Gears with play, which the joint crosses before it takes the link along."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.physics.effect import Departure, shifted
from robolaser.trials.worlds.arm import Arm


@final
@dataclass(frozen=True)
class Play(Departure):
    """The link hangs behind its motor by half the play, on the side that it came from.

    Attributes:
        size: The whole play [rad].
        engagement: Travel over which friction takes it up to a third [rad]; 0: the teeth are hard.
    """

    name: ClassVar[str] = "backlash"

    engagement: float = 0.0

    def follow(self, motor: float, last: float, hanging: float) -> float:
        """Between minus and plus half the play."""
        half, move = self.size / 2, motor - last
        if self.engagement == 0.0:
            return float(np.clip(hanging + move, -half, half))
        end = half * float(np.sign(move))
        return end + (hanging - end) * float(np.exp(-abs(move) / self.engagement))

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """Behind."""
        return shifted(q, column, -hanging)
