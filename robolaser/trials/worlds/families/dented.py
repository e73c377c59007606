"""Targets with a dent: the library of effects has no such thing."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Dented(Departure):
    """A bell-shaped dent of some centimetres."""

    effect: ClassVar[str] = "dented_target"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 1.5e-3)

    aside: tuple[float, float]
    width: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, tuple(rng.uniform(-0.5, 0.5, 2).tolist()), rng.uniform(0.03, 0.09))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The target."""
        return ("target",)

    def height(self, along: Array, run: Run) -> Array:
        """`size` [m] deep."""
        away = (along - run.radius * np.array(self.aside)) / self.width
        depth: Array = -self.size * np.exp(-0.5 * (away**2).sum(axis=1))
        return depth
