"""Hoses and cables that pull at the flange: the library of effects has no such thing."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run

WRIST = 3  # joints


@final
@dataclass(frozen=True)
class Hose(Departure):
    """A spring from the ceiling to the flange turns the wrist's joints against their stiffness."""

    effect: ClassVar[str] = "hose"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 4e-3)

    anchor: tuple[float, float, float]
    slack: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(
            where,
            size,
            tuple((run.middle + rng.uniform(-1, 1, 3) * [0.6, 0.6, 0.2] + [0.0, 0.0, 1.2]).tolist()),
            rng.uniform(0.1, 0.5),
        )

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """It is laid along the whole wrist; truth names the last joint but one."""
        return run.arm.joints[-2:-1]

    def joints(self, q: Array, run: Run) -> Array:
        """Each of the last joints by what the pull turns it, at most `size` [rad]."""
        away = np.array(self.anchor) - run.arm.forward(q)[:, :3, 3]
        length = np.linalg.norm(away, axis=1)
        pull = away * (np.maximum(0.0, length - self.slack) / length)[:, None]
        wrist = [run.column(joint) for joint in run.arm.joints[-WRIST:]]
        turn = np.einsum("nij,ni->nj", run.arm.levers(q)[:, :, wrist], pull)
        q = q.copy()
        q[:, wrist] += self.size * turn / np.abs(turn).max()
        return q
