"""Targets that are not flat."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Warped(Departure):
    """A roof tile, a saddle or a wave."""

    effect: ClassVar[str] = "target_warp"
    sizes: ClassVar[tuple[float, float]] = (1e-4, 1.5e-3)

    form: str
    heading: float
    length: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(
            where, size, str(rng.choice(["tile", "saddle", "wave"])), rng.uniform(-np.pi, np.pi), rng.uniform(1.5, 4.0)
        )

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The target."""
        return ("target",)

    def height(self, along: Array, run: Run) -> Array:
        """About `size` [m] at the rim."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x, y = along[:, 0] / run.radius, along[:, 1] / run.radius
        x, y = cos * x + sin * y, cos * y - sin * x
        forms = {"tile": x**2, "saddle": x * y, "wave": np.sin(2 * np.pi * x / self.length)}
        height: Array = self.size * forms[self.form]
        return height
