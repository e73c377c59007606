"""Links that grow while the motors warm them."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run

LEAST_LENGTH_M = 0.05


@final
@dataclass(frozen=True)
class Warming(Departure):
    """The link before a joint grows: towards an end, with a time constant that nobody knows."""

    effect: ClassVar[str] = "thermal_drift"
    sizes: ClassVar[tuple[float, float]] = (1e-4, 1.2e-3)

    tau: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, float(np.exp(rng.uniform(np.log(0.1), np.log(1.0)))))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Joints that a link of some length carries; the link to the first belongs to the base."""
        lengths = np.linalg.norm(run.arm.links[:, :3, 3], axis=1)
        return tuple(joint for joint in run.arm.joints[1:] if lengths[run.column(joint)] > LEAST_LENGTH_M)

    def links(self, links: Array, run: Run) -> Array:
        """Longer by `size` [m] once warm."""
        links = links.copy()
        along = links[:, run.column(self.where), :3, 3]
        grown = run.warmed(self.tau) / run.warmed(self.tau).max()
        along += self.size * grown[:, None] * along / np.linalg.norm(along, axis=1, keepdims=True)
        return links
