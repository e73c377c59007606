"""Targets that were printed too large or too small."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Misprint(Departure):
    """Drawn distances are too short or too long by one share."""

    effect: ClassVar[str] = "target_scale"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 1.2e-2)

    aside: tuple[float, float]

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])), tuple(rng.uniform(-0.5, 0.5, 2).tolist()))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The target."""
        return ("target",)

    def printed(self, along: Array, run: Run) -> Array:
        """About the grid's origin, which lies somewhere on it."""
        origin = run.radius * np.array(self.aside)
        return origin + (along - origin) / (1.0 + self.size)
