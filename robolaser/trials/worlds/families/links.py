"""Links that were not made as drawn."""

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.run import Run


@final
@dataclass(frozen=True)
class Link(Departure):
    """The joint sits elsewhere on the link before it: in some of six ways."""

    effect: ClassVar[str] = "link_geometry"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)

    way: tuple[float, ...]

    @classmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """Of this size."""
        return cls(where, size, _way(rng))

    @classmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return run.arm.joints

    def links(self, links: Array, run: Run) -> Array:
        """Shifted by up to `size` [m] and turned by up to as many radians."""
        links = links.copy()
        column = run.column(self.where)
        way = self.size * np.array(self.way)
        links[:, column, :3, 3] += links[:, column, :3, :3] @ way[:3]
        links[:, column, :3, :3] = links[:, column, :3, :3] @ Rotation.from_rotvec(way[3:]).as_matrix()
        return links


def _way(rng: np.random.Generator) -> tuple[float, ...]:
    way = rng.uniform(-1.0, 1.0, 6)
    way[rng.permutation(6)[: rng.integers(0, 6)]] = 0.0
    return tuple((way / np.abs(way).max()).tolist())
