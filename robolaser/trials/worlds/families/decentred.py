"""Lenses whose elements are not on one axis."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Decentred(Departure):
    """OpenCV's p1 and p2."""

    effect: ClassVar[str] = "tangential_distortion"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 1e-2)

    towards: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, rng.uniform(-np.pi, np.pi))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The lens."""
        return ("camera",)

    def lens(self, terms: Array) -> Array:
        """Off to one side."""
        side = self.size * np.array([np.cos(self.towards), np.sin(self.towards)])
        bent: Array = terms + np.array([0.0, 0.0, *side, 0.0])
        return bent
