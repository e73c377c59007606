"""Exposures that wait while the arm brakes."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Late(Departure):
    """The arm moved on after the reading, and slowed down meanwhile."""

    effect: ClassVar[str] = "latency"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 8e-3)

    braking: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])), rng.uniform(0.01, 0.1))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Between controller and camera; in an arm at rest it changes nothing."""
        return ("timing",) if run.qd.any() else ()

    def joints(self, q: Array, run: Run) -> Array:
        """Where it was when the shutter opened."""
        waited = -self.braking * np.expm1(-abs(self.size) / self.braking)
        moved: Array = q + run.qd * np.sign(self.size) * waited
        return moved
