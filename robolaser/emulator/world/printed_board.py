"""A printed board on a thin plate."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.printed_board import BoardPrint
from robolaser.emulator.world.solids import Solid

BORDER_M = 0.01
PAPER, INK = 0.85, 0.09  # shares of light that they reflect


@final
@dataclass(frozen=True, eq=False)
class PrintedBoard(Solid):
    """A checkerboard with or without markers, with a light border around it.

    Attributes:
        T_base_board: Its frame: the origin is the inner corner whose outward diagonal square is dark, x runs along the
            columns, y along the rows, z into the board, (4, 4).
        pattern: What is on it.
    """

    T_base_board: Array
    pattern: BoardPrint

    def hit(self, origin: Array, direction: Array) -> Array:
        """From either side."""
        R, t = self.T_base_board[:3, :3], self.T_base_board[:3, 3]
        start, along = (origin - t) @ R, direction @ R
        cell = self.pattern.cell_m
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = -start[..., 2] / along[:, 2]
            on = distance > 0
            for i, count in enumerate(self.pattern.dark.shape[::-1]):
                middle = (count / 2 - self.pattern.first) * cell
                on &= np.abs(start[..., i] + distance * along[:, i] - middle) <= count / 2 * cell + BORDER_M
        return np.where(on, distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Out of the printed side."""
        return np.broadcast_to(-self.T_base_board[:3, 2], point.shape)

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """Paper and ink, mixed where a pixel sees both."""
        R, t = self.T_base_board[:3, :3], self.T_base_board[:3, 3]
        place, ray = (point - t) @ R / self.pattern.cell_m, (point - eye) @ R / self.pattern.cell_m
        footprint = breadth * np.linalg.norm(ray, axis=-1)
        lines, beyond, printed = [], [], np.ones(len(point))
        for i, count in enumerate(self.pattern.dark.shape[::-1]):
            x = place[:, i] + self.pattern.first
            sharp = 1.0 / (footprint * np.hypot(1.0, ray[:, i] / ray[:, 2]))
            line = np.clip(np.rint(x), 1.0, count - 1.0)
            lines.append(line.astype(np.int64))
            beyond.append(np.clip((x - line) * sharp + 0.5, 0.0, 1.0))
            printed *= np.clip((count / 2 - np.abs(x - count / 2)) * sharp + 0.5, 0.0, 1.0)
        (column, row), (right, below) = lines, beyond
        ink = sum(
            self.pattern.dark[row - up, column - left]
            * np.where(up, 1.0 - below, below)
            * np.where(left, 1.0 - right, right)
            for up in (0, 1)
            for left in (0, 1)
        )
        albedo: Array = PAPER + (INK - PAPER) * ink * printed
        return albedo
