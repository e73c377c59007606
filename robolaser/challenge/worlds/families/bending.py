"""Joints that give way under all that they carry, and stiffen as they do."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.challenge.worlds.departure import Departure
from robolaser.challenge.worlds.run import Run


@final
@dataclass(frozen=True)
class Bending(Departure):
    """Windup under the full torque, payload and all: less for each further newton metre."""

    effect: ClassVar[str] = "joint_compliance"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2.5e-3)

    hardening: float

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, rng.uniform(0.0, 0.3))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def joints(self, q: Array, run: Run) -> Array:
        """Sunk: by `size` [rad] under the largest torque of the run."""
        q = q.copy()
        column = run.column(self.where)
        torque = run.arm.torques(run.q, run.payload_kg)[:, column]
        load = torque / max(1e-9, float(np.abs(torque).max()))
        q[:, column] -= self.size * load * (1.0 + self.hardening) / (1.0 + self.hardening * np.abs(load))
        return q
