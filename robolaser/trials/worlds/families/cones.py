"""Projectors whose light is a shallow cone."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.light import Light
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Cone(Departure):
    """What a rod lens makes of a beam that does not cross it squarely."""

    effect: ClassVar[str] = "laser_curvature"
    sizes: ClassVar[tuple[float, float]] = (3e-3, 6e-2)

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The projector."""
        return ("laser",)

    def light(self, light: Light, run: Run) -> Light:
        """Off the plane by `size` [rad]."""
        return replace(light, cone=light.cone + self.size)
