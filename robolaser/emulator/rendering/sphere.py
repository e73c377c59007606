"""A ball."""

from dataclasses import dataclass
from itertools import product
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.solid import Solid
from robolaser.emulator.rendering.vectors import dot


@final
@dataclass(frozen=True)
class Ball(Solid):
    """A ball.

    Attributes:
        centre: (3,) [m].
        radius: [m].
        tone: Its albedo.
        shine: Share of the light that it mirrors.
    """

    centre: Array
    radius: float
    tone: float = 0.7
    shine: float = 0.0

    def hit(self, origin: Array, direction: Array) -> Array:
        """From outside."""
        towards = self.centre - origin
        along = dot(direction, towards)
        beside = towards - along[..., None] * direction
        miss2 = dot(beside, beside)
        half = np.sqrt(np.maximum(self.radius**2 - miss2, 0.0))
        distance = along - half
        return np.where((miss2 < self.radius**2) & (distance > 0), distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Away from the centre."""
        normal: Array = (point - self.centre) / self.radius
        return normal

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """The same everywhere."""
        return np.full(point.shape[:-1], self.tone)

    def corners(self) -> Array:
        """Of the cube around it."""
        return self.centre + self.radius * np.array(list(product((-1.0, 1.0), repeat=3)))
