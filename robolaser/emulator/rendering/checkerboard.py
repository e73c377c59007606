"""A printed checkerboard on a thin plate."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.solid import Face, Solid
from robolaser.emulator.rendering.vectors import dot


@final
@dataclass(frozen=True)
class Checkerboard(Solid):
    """A checkerboard, with a light border around its outer squares.

    Attributes:
        T_base_board: Its frame: the origin is the inner corner whose outward diagonal square is dark, x runs along the
            columns, y along the rows, z into the board, (4, 4).
        columns: Inner corners along x.
        rows: Inner corners along y.
        square_m: Side of a square [m].
        border_m: Breadth of the border [m].
        white: Albedo of the paper.
        black: Albedo of the ink.
        shine: Share of the light that it mirrors.
    """

    T_base_board: Array
    columns: int
    rows: int
    square_m: float
    border_m: float = 0.01
    white: float = 0.85
    black: float = 0.09
    shine: float = 0.0

    def grid(self) -> Array:
        """Its inner corners in the base frame, (rows, columns, 3) [m]."""
        x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        return self._placed(self.square_m * np.stack([x, y, 0.0 * x], axis=-1, dtype=np.float64))

    def hit(self, origin: Array, direction: Array) -> Array:
        """From either side."""
        R, t = self.T_base_board[:3, :3], self.T_base_board[:3, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (t - origin) @ R[:, 2] / (direction @ R[:, 2])
            on = distance > 0
            for i, (low, high) in enumerate(zip(*self._ends, strict=True)):
                place = (origin - t) @ R[:, i] + distance * (direction @ R[:, i])
                on &= np.abs(place - (low + high) / 2) <= (high - low) / 2
        return np.where(on, distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Out of the printed side."""
        return np.broadcast_to(-self.T_base_board[:3, 2], point.shape)

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """Paper and ink, mixed where a pixel sees both."""
        R, t = self.T_base_board[:3, :3], self.T_base_board[:3, 3]
        ray = (point - eye) @ R / self.square_m
        place = (ray[:, :2] + (eye - t) @ R[:, :2] / self.square_m).astype(np.float32)
        footprint2 = (breadth**2 * dot(ray, ray)).astype(np.float32)
        steep = (ray[:, :2] / ray[:, 2:]).astype(np.float32)
        side, printed = np.ones_like(footprint2), np.ones_like(footprint2)
        for i, last in enumerate((self.columns - 1, self.rows - 1)):
            x = place[:, i]
            sharp = 1.0 / np.sqrt(footprint2 * (1.0 + steep[:, i] ** 2))
            line = np.minimum(np.maximum(np.rint(x), 0.0), last)
            side *= np.minimum(np.maximum(2.0 * (x - line) * sharp, -1.0), 1.0)
            side *= 1.0 - 2.0 * (line - 2.0 * np.floor(line / 2.0))
            edge = (last / 2 + 1.0 - np.abs(x - last / 2)) * sharp + 0.5
            printed *= np.minimum(np.maximum(edge, 0.0), 1.0)
        return (self.white + (self.black - self.white) * (0.5 + 0.5 * side) * printed).astype(np.float64)

    def corners(self) -> Array:
        """The plate's four."""
        (x, y), (right, down) = self._ends
        return self._placed(np.array([[x, y, 0], [right, y, 0], [right, down, 0], [x, down, 0]]))

    def faces(self) -> tuple[Face]:
        """The printed one."""
        low, high = self._ends
        middle = self._placed(np.append((low + high) / 2, 0.0))
        R = self.T_base_board[:3, :3]
        return (Face(middle, -R[:, 2], R.T[:2], (high - low) / 2),)

    @property
    def _ends(self) -> tuple[Array, Array]:
        room = self.square_m + self.border_m
        return np.array([-room, -room]), self.square_m * (np.array([self.columns, self.rows]) - 1.0) + room

    def _placed(self, point: Array) -> Array:
        placed: Array = point @ self.T_base_board[:3, :3].T + self.T_base_board[:3, 3]
        return placed
