"""What a camera at a place meets in a scene, ray by ray."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.emulator.rendering.camera import CameraModel
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.scene import TIE_M, EmulatedScene

ROOM_PX = 3.0  # around the box of a solid's corners: lenses bend straight edges
NEAREST_M = 0.01  # what comes nearer is not boxed in


@final
@dataclass(frozen=True)
class Hits:
    """What rays met, one entry a ray (n).

    Attributes:
        ray: Unit vectors of the camera frame, (n, 3).
        distance: (n,) [m]; inf where there was nothing.
        solid: Numbers of the solids, (n,), or -1.
    """

    ray: Array
    distance: Array
    solid: Ints

    @property
    def seen(self) -> Array:
        """Points in the camera frame, (n, 3) [m]."""
        with np.errstate(invalid="ignore"):
            point: Array = self.ray * self.distance[:, None]
        return point

    def take(self, rows: Ints) -> "Hits":
        """Some of them."""
        return Hits(self.ray[rows], self.distance[rows], self.solid[rows])


@final
@dataclass(frozen=True, eq=False)
class SceneView:
    """A scene before an eye."""

    scene: EmulatedScene
    eye: CameraModel
    T_base_camera: Array

    @property
    def turn(self) -> Array:
        """Turn of the camera in the base frame, (3, 3)."""
        turn: Array = self.T_base_camera[:3, :3]
        return turn

    @property
    def place(self) -> Array:
        """Of the camera in the base frame, (3,) [m]."""
        place: Array = self.T_base_camera[:3, 3]
        return place

    @cached_property
    def all(self) -> Hits:
        """What the middle of every pixel shows, row by row, (height * width)."""
        height, width = self.eye.height_px, self.eye.width_px
        direction = (self.eye.all_rays.reshape(-1, 3) @ self.turn.T).reshape(height, width, 3)
        nearest, index = np.full((height, width), np.inf), np.full((height, width), -1)
        for i, solid in enumerate(self.scene.solids):
            box = self._box(solid.corners())
            distance = solid.hit(self.place, direction[box])
            before = (distance <= nearest[box] + TIE_M) & (distance < np.inf)
            np.copyto(nearest[box], distance, where=before)
            np.copyto(index[box], i, where=before)
        return Hits(self.eye.all_rays.reshape(-1, 3), nearest.ravel(), index.ravel())

    def along(self, ray: Array) -> Hits:
        """What rays of the camera frame meet, (n, 3)."""
        return Hits(ray, *self.scene.cast(self.place, ray @ self.turn.T))

    def outside(self, point: Array) -> Array:
        """Points of the camera frame in the base frame, (n, 3) [m]."""
        placed: Array = point @ self.turn.T + self.place
        return placed

    def lit(self, sheet: LaserSheet, hits: Hits) -> Bools:
        """Whether the projector's light reaches what rays met, (n,)."""
        point = self.outside(hits.seen)
        free: Bools = hits.solid >= 0
        rows = np.flatnonzero(free)
        normal = self.scene.normals(point[rows], hits.solid[rows])
        free[rows] = self.scene.reaches(point[rows], normal, self.outside(sheet.source))
        return free

    def _box(self, corners: Array | None) -> tuple[slice, slice]:
        """Rows and columns that may show what has these corners."""
        whole = slice(0, self.eye.height_px), slice(0, self.eye.width_px)
        if corners is None:
            return whole
        inside = (corners - self.place) @ self.turn
        if inside[:, 2].min() < NEAREST_M:
            return whole if inside[:, 2].max() > 0 else (slice(0, 0), slice(0, 0))
        pixel = self.eye.pixels(inside)
        low, high = pixel.min(axis=0) - ROOM_PX, pixel.max(axis=0) + ROOM_PX
        (left, top), (right, bottom) = np.maximum(low, 0).astype(int), np.maximum(high, 0).astype(int) + 1
        return slice(top, bottom), slice(left, right)
