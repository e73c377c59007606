"""Glints and lost stripes: some pixels are far off."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run

FAR_PX = (2.0, 40.0)


@final
@dataclass(frozen=True)
class Gross(Departure):
    """In some points, or only in some of their shots."""

    effect: ClassVar[str] = "outliers"
    sizes: ClassVar[tuple[float, float]] = (0.01, 0.06)

    lasting: bool

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, bool(rng.random() < 0.5))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Any point."""
        return ("image",)

    def shots(self, pixel: Array, shot: Ints, rng: np.random.Generator) -> Array:
        """Thrown off by 2 to 40 pixels, any way."""
        points = np.unique(shot)
        hit = np.isin(shot, points[rng.random(len(points)) < self.size])
        if not self.lasting:
            hit = rng.random(len(shot)) < self.size
        group = shot if self.lasting else np.arange(len(shot))
        way = rng.uniform(-np.pi, np.pi, len(shot))[group]
        far = np.exp(rng.uniform(np.log(FAR_PX[0]), np.log(FAR_PX[1]), len(shot)))[group]
        thrown: Array = pixel + np.where(hit, far, 0.0)[:, None] * np.stack([np.cos(way), np.sin(way)], axis=-1)
        return thrown
