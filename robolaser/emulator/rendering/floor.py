"""A level floor without end."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.solid import Face, Solid

UP = np.array([0.0, 0.0, 1.0])


@final
@dataclass(frozen=True)
class Floor(Solid):
    """The plane z = height.

    Attributes:
        height: In the base frame [m].
        tone: Its albedo.
        shine: Share of the light that it mirrors.
    """

    height: float = 0.0
    tone: float = 0.45
    shine: float = 0.0

    def hit(self, origin: Array, direction: Array) -> Array:
        """From either side."""
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (self.height - origin[..., 2]) / direction[..., 2]
        return np.where(distance > 0, distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Up."""
        return np.broadcast_to(UP, point.shape)

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """The same everywhere."""
        return np.full(point.shape[:-1], self.tone)

    def corners(self) -> None:
        """None: it has no end."""

    def plain(self) -> tuple[Array, float]:
        """Up, and its tone."""
        return UP, self.tone

    def faces(self) -> tuple[Face]:
        """Itself."""
        return (Face(np.array([0.0, 0.0, self.height]), UP, np.eye(3)[:2], np.full(2, np.inf)),)
