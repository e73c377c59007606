"""Encoders whose counts are not quite what a turn takes."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Gain(Departure):
    """Counts a turn are off by a share."""

    effect: ClassVar[str] = "encoder_scale"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def joints(self, q: Array, run: Run) -> Array:
        """Stretched from the zero."""
        q = q.copy()
        q[:, run.column(self.where)] *= 1.0 + self.size
        return q
