"""Brackets that creep, steadily or ever more slowly."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Creep(Departure):
    """The camera moves on its bracket, in a straight line or by the logarithm of time."""

    effect: ClassVar[str] = "hand_eye_drift"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 3e-3)

    settling: float
    way: tuple[float, ...]

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, rng.choice([0.0, rng.uniform(0.02, 0.3)]), tuple(rng.uniform(-1.0, 1.0, 6).tolist()))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """The bracket."""
        return ("hand_eye",)

    def mount(self, T_flange_camera: Array, run: Run) -> Array:
        """Off by up to `size` [m] and radians at the end."""
        s = self.settling
        share = np.log1p(run.share / s) / np.log1p(1.0 / s) if s else run.share
        way = self.size * share[:, None] * np.array(self.way)
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += way[:, :3]
        moved[:, :3, :3] = moved[:, :3, :3] @ Rotation.from_rotvec(way[:, 3:]).as_matrix()
        return moved
