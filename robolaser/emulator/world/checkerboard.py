"""A printed checkerboard on a thin plate."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.world.solids import Solid


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
        tone: Of the paper.
        black: Share of light that the ink reflects.
    """

    T_base_board: Array
    columns: int
    rows: int
    square_m: float
    border_m: float = 0.01
    tone: float = 0.85
    black: float = 0.09

    def hit(self, origin: Array, direction: Array) -> Array:
        """From either side."""
        R, t = self.T_base_board[:3, :3], self.T_base_board[:3, 3]
        start, along = (origin - t) @ R, direction @ R
        room = self.square_m + self.border_m
        ends = self.square_m * (np.array([self.columns, self.rows]) - 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = -start[..., 2] / along[:, 2]
            on = distance > 0
            for i, end in enumerate(ends):
                on &= np.abs(start[..., i] + distance * along[:, i] - end / 2) <= end / 2 + room
        return np.where(on, distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Out of the printed side."""
        return np.broadcast_to(-self.T_base_board[:3, 2], point.shape)

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """Paper and ink, mixed where a pixel sees both."""
        R, t = self.T_base_board[:3, :3], self.T_base_board[:3, 3]
        place, ray = (point - t) @ R / self.square_m, (point - eye) @ R / self.square_m
        footprint = breadth * np.linalg.norm(ray, axis=-1)
        side, printed = np.ones(len(point)), np.ones(len(point))
        for i, last in enumerate((self.columns - 1, self.rows - 1)):
            x = place[:, i]
            sharp = 1.0 / (footprint * np.hypot(1.0, ray[:, i] / ray[:, 2]))
            line = np.clip(np.rint(x), 0.0, last)
            side *= np.clip(2.0 * (x - line) * sharp, -1.0, 1.0) * (1.0 - 2.0 * (line % 2))
            printed *= np.clip((last / 2 + 1.0 - np.abs(x - last / 2)) * sharp + 0.5, 0.0, 1.0)
        albedo: Array = self.tone + (self.black - self.tone) * (0.5 + 0.5 * side) * printed
        return albedo
