"""Stripes whose centre is read beside them where the surface is tilted."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Biased(Departure):
    """One flank of the stripe is brighter: as the tangent or the sine of the tilt."""

    effect: ClassVar[str] = "stripe_bias"
    sizes: ClassVar[tuple[float, float]] = (0.1, 2.0)

    steep: bool

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])), bool(rng.random() < 0.5))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The projector."""
        return ("laser",)

    def stripe(self, tilt: Array) -> Array:
        """`size` pixels at 45 degrees, about."""
        return self.size * (np.tan(tilt) if self.steep else np.sin(tilt))
