"""Lenses that bulge in higher terms than one."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Bulging(Departure):
    """OpenCV's second and third radial terms."""

    effect: ClassVar[str] = "radial_distortion"
    sizes: ClassVar[tuple[float, float]] = (0.05, 0.9)

    third: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])), rng.choice([0.0, rng.uniform(-2.0, 2.0)]))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The lens."""
        return ("camera",)

    def lens(self, terms: Array) -> Array:
        """With k2 = `size` and k3 in proportion."""
        bent: Array = terms + np.array([0.0, self.size, 0.0, 0.0, self.third * self.size])
        return bent
