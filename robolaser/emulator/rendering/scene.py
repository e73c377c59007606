"""All that stands before the camera, and what rays meet there first."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.emulator.rendering.solid import Solid
from robolaser.emulator.rendering.vectors import dot

AWAY_M = 1e-7  # from the surface that a ray leaves
TIE_M = 1e-9  # nearer together than this the solid listed later is in front


@final
@dataclass(frozen=True)
class EmulatedScene:
    """Solids in the base frame; where two coincide, the later one lies on top."""

    solids: tuple[Solid, ...]

    def cast(self, origin: Array, direction: Array) -> tuple[Array, Ints]:
        """What rays meet first.

        Args:
            origin: Where they start, (n, 3) or (3,) [m].
            direction: Unit vectors, (n, 3).

        Returns:
            Distances, (n,) [m], inf where there is nothing; numbers of the solids, (n,), then -1.
        """
        nearest = np.full(len(direction), np.inf)
        index = np.full(len(direction), -1)
        for i, solid in enumerate(self.solids):
            distance = solid.hit(origin, direction)
            before = (distance <= nearest + TIE_M) & (distance < np.inf)
            nearest, index = np.where(before, distance, nearest), np.where(before, i, index)
        return nearest, index

    def reaches(self, point: Array, normal: Array, source: Array) -> Bools:
        """Whether light from a source reaches points of surfaces with these normals, (n, 3) -> (n,)."""
        towards = source - point
        far = np.sqrt(dot(towards, towards))
        direction = towards / far[:, None]
        free: Bools = dot(direction, normal) > 0
        start = point + AWAY_M * normal
        for solid in self.solids:
            free = free & (solid.hit(start, direction) > far - 2 * AWAY_M)
        return free

    def normals(self, point: Array, index: Ints) -> Array:
        """Unit normals at points of these solids, (n, 3)."""
        normal = np.zeros_like(point)
        for i, solid in enumerate(self.solids):
            own = np.flatnonzero(index == i)
            normal[own] = solid.normal(point[own])
        return normal

    def albedo(self, point: Array, index: Ints, eye: Array, breadth: float) -> Array:
        """Share of light thrown back at points of these solids, (n,), see `Solid.albedo`."""
        albedo = np.zeros(len(point))
        for i, solid in enumerate(self.solids):
            own = np.flatnonzero(index == i)
            albedo[own] = solid.albedo(point[own], eye, breadth)
        return albedo

    @property
    def shine(self) -> Array:
        """Share of light that each solid mirrors, (solids,)."""
        return np.array([solid.shine for solid in self.solids])
