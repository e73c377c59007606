"""Gears whose error repeats with the motor: two harmonics, in no fixed ratio or phase."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Gear(Departure):
    """One cycle and two cycles a turn of something inside, 2 to 160 times as fast as the joint."""

    effect: ClassVar[str] = "transmission_error"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2e-3)

    ratio: float
    second: float
    phases: tuple[float, float]

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, _ratio(rng), rng.uniform(0.0, 0.8), tuple(rng.uniform(-np.pi, np.pi, 2).tolist()))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def joints(self, q: Array, run: Run) -> Array:
        """Off by both."""
        q = q.copy()
        column = run.column(self.where)
        motor = self.ratio * q[:, column]
        once, twice = (np.sin((i + 1) * motor + phase) for i, phase in enumerate(self.phases))
        q[:, column] += self.size * (once + self.second * twice)
        return q


def _ratio(rng: np.random.Generator) -> float:
    """Whole for the gears that the trade sells most, anything for the rest."""
    ratio = float(np.exp(rng.uniform(np.log(2.0), np.log(160.0))))
    return float(round(ratio)) if rng.random() < 0.5 else ratio
