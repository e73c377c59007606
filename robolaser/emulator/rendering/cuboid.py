"""A cuboid: on a floor its top is a step."""

from dataclasses import dataclass
from itertools import product
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.solid import Face, Solid


@final
@dataclass(frozen=True)
class Cuboid(Solid):
    """A cuboid.

    Attributes:
        T_base_block: Its frame, in the middle of its underside, z towards the top, (4, 4).
        size: Along its x, y and z, (3,) [m].
        tone: Its albedo.
        shine: Share of the light that it mirrors.
    """

    T_base_block: Array
    size: tuple[float, float, float]
    tone: float = 0.6
    shine: float = 0.0

    def hit(self, origin: Array, direction: Array) -> Array:
        """Slab by slab, from outside."""
        R, t = self.T_base_block[:3, :3], self.T_base_block[:3, 3]
        start, along = (origin - t) @ R, direction @ R
        enter, leave = np.full(along.shape[:-1], -np.inf), np.full(along.shape[:-1], np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for i, (low, high) in enumerate(self._slabs):
                one, other = (low - start[..., i]) / along[..., i], (high - start[..., i]) / along[..., i]
                enter, leave = np.fmax(enter, np.fmin(one, other)), np.fmin(leave, np.fmax(one, other))
        return np.where((enter <= leave) & (enter > 0), enter, np.inf)

    def normal(self, point: Array) -> Array:
        """Of the face that lies nearest."""
        R, t = self.T_base_block[:3, :3], self.T_base_block[:3, 3]
        inside = (point - t) @ R
        low, high = np.array(self._slabs).T
        depth = np.concatenate([np.abs(inside - low), np.abs(inside - high)], axis=-1)
        outward = np.concatenate([-R.T, R.T])
        normal: Array = outward[depth.argmin(axis=-1)]
        return normal

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """The same everywhere."""
        return np.full(point.shape[:-1], self.tone)

    def corners(self) -> Array:
        """Its eight."""
        corners = np.array(list(product(*self._slabs)))
        placed: Array = corners @ self.T_base_block[:3, :3].T + self.T_base_block[:3, 3]
        return placed

    def faces(self) -> tuple[Face, ...]:
        """All six."""
        R, half = self.T_base_block[:3, :3], np.array(self.size) / 2
        middle = self.T_base_block[:3, 3] + R[:, 2] * half[2]
        return tuple(
            Face(middle + sign * half[i] * R[:, i], sign * R[:, i], np.delete(R.T, i, axis=0), np.delete(half, i))
            for i in range(3)
            for sign in (-1.0, 1.0)
        )

    @property
    def _slabs(self) -> tuple[tuple[float, float], ...]:
        x, y, z = self.size
        return (-x / 2, x / 2), (-y / 2, y / 2), (0.0, z)
