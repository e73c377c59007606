"""Encoders that start from a wrong zero."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Zero(Departure):
    """The zero is off."""

    effect: ClassVar[str] = "joint_offset"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size * float(rng.choice([-1.0, 1.0])))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def joints(self, q: Array, run: Run) -> Array:
        """Turned on by the error."""
        q = q.copy()
        q[:, run.column(self.where)] += self.size
        return q
