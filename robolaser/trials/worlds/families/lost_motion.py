"""Gears with play, which remembers the way the joint came."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class LostMotion(Departure):
    """A play operator: the output rests until the input has crossed the gap."""

    effect: ClassVar[str] = "backlash"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 3e-3)

    began: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, rng.uniform(-1.0, 1.0))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def joints(self, q: Array, run: Run) -> Array:
        """Dragged along by half the play, straight from pose to pose, in the order of time."""
        q = q.copy()
        column = run.column(self.where)
        half = self.size / 2
        output = q[run.order[0], column] + half * self.began
        for row in run.order:
            output = min(max(output, q[row, column] - half), q[row, column] + half)
            q[row, column] = output
        return q
