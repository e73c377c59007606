"""Joints that are turned by another joint: the library of effects has no such thing."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class CrossTalk(Departure):
    """An error of one joint that follows another's angle, straight or as a sine."""

    effect: ClassVar[str] = "cross_talk"
    sizes: ClassVar[tuple[float, float]] = (4e-4, 4e-3)

    other: str
    straight: bool

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, _other(where, run, rng), bool(rng.random() < 0.5))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that has a neighbour."""
        return run.arm.joints if len(run.arm.joints) > 1 else ()

    def joints(self, q: Array, run: Run) -> Array:
        """Turned on by up to `size` [rad] across the other's range."""
        q = q.copy()
        other = run.q[:, run.column(self.other)]
        middle, half = (other.max() + other.min()) / 2, max(1e-9, float(np.ptp(other)) / 2)
        swing = (other - middle) / half
        q[:, run.column(self.where)] += self.size * (swing if self.straight else np.sin(np.pi * swing))
        return q


def _other(where: str, run: Run, rng: np.random.Generator) -> str:
    at = run.arm.joints.index(where)
    return str(rng.choice([joint for i, joint in enumerate(run.arm.joints) if abs(i - at) in (1, 2)]))
