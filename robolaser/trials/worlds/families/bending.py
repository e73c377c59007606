"""Joints that give way under all that they carry, and stiffen as they do."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run

LEAST_SWING_NM = 0.2  # of the torque over the run
ALIKE = 0.98  # correlation of the torques with and without payload


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
        """Joints on which the URDF's masses weigh, and much as the whole weight does: else nobody could name it."""
        whole = run.arm.torques(run.q, run.payload_kg)
        masses = run.arm.torques(run.q, 0.0)
        alike = [
            np.corrcoef(*pair)[0, 1] if min(np.ptp(pair, axis=1)) > LEAST_SWING_NM else 0.0
            for pair in zip(whole.T, masses.T, strict=True)
        ]
        return tuple(joint for joint in run.arm.joints if alike[run.column(joint)] > ALIKE)

    def joints(self, q: Array, run: Run) -> Array:
        """Sunk: by `size` [rad] under the largest torque of the run."""
        q = q.copy()
        column = run.column(self.where)
        torque = run.arm.torques(run.q, run.payload_kg)[:, column]
        load = torque / max(1e-9, float(np.abs(torque).max()))
        q[:, column] -= self.size * load * (1.0 + self.hardening) / (1.0 + self.hardening * np.abs(load))
        return q
