"""Encoder discs that do not sit on their axis."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class OffCentre(Departure):
    """A disc off its axis, by exact geometry and not only in first order."""

    effect: ClassVar[str] = "encoder_eccentricity"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)

    towards: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, rng.uniform(-np.pi, np.pi))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def joints(self, q: Array, run: Run) -> Array:
        """What the axis did when the head read q beside it."""
        q = q.copy()
        column = run.column(self.where)
        angle = q[:, column] - self.towards
        q[:, column] += np.arctan2(self.size * np.sin(angle), 1.0 - self.size * np.cos(angle))
        return q
