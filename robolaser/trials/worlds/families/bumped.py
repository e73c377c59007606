"""Bases or targets that somebody bumped into while the arm worked."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Bumped(Departure):
    """From one pose on, everything stands elsewhere."""

    effect: ClassVar[str] = "base_shift"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 1.5e-3)

    moment: float
    way: tuple[float, ...]

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, rng.uniform(0.2, 0.8), tuple(rng.uniform(-1.0, 1.0, 6).tolist()))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Between base and target."""
        return ("base",)

    def flange(self, T_base_flange: Array, run: Run) -> Array:
        """Moved by up to `size` [m] and turned by up to as many radians, about the target."""
        way = self.size * np.array(self.way)
        bump = np.eye(4)
        bump[:3, :3] = Rotation.from_rotvec(way[3:]).as_matrix()
        bump[:3, 3] = way[:3] + run.middle - bump[:3, :3] @ run.middle
        return np.where((run.share > self.moment)[:, None, None], bump @ T_base_flange, T_base_flange)
