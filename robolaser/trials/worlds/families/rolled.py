"""Projectors that are turned about the view."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.light import Light
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Rolled(Departure):
    """The stripe is not parallel to the image's axis."""

    effect: ClassVar[str] = "laser_roll"
    sizes: ClassVar[tuple[float, float]] = (2e-3, 6e-2)

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The projector."""
        return ("laser",)

    def light(self, light: Light, run: Run) -> Light:
        """By `size` [rad]."""
        return replace(light, roll=light.roll + self.size)
