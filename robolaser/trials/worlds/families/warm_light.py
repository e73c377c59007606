"""Projectors whose beam wanders until they are warm."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.light import Light
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class WarmLight(Departure):
    """The angle goes to another end, with a time constant of its own."""

    effect: ClassVar[str] = "laser_drift"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 3e-3)

    tau: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])), float(np.exp(rng.uniform(np.log(0.08), np.log(1.0)))))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The projector."""
        return ("laser",)

    def light(self, light: Light, run: Run) -> Light:
        """By `size` [rad] in the end."""
        return replace(light, theta=light.theta + self.size * run.warmed(self.tau))
