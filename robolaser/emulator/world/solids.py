"""Bodies for the emulated camera: floor, sphere, block and printed board, in the base frame."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.data.board import BoardPrint
from robolaser.data.toml_schema import NotNegative, Positive
from robolaser.geometry.rigid_motion import Quaternion

Vector = tuple[float, float, float]
BORDER_M = 0.01  # of a board's plate
PAPER, INK = 0.85, 0.09  # shares of light that they reflect
UP = np.array([0.0, 0.0, 1.0])


class Solid(ABC):
    """A body whose surface reflects light diffusely; `tone` is the share of it, 0 to 1."""

    tone: float

    @abstractmethod
    def hit(self, origin: Array, direction: Array) -> Array:
        """Distances of rays to the surface, (n,) [m]; inf where they miss it.

        From origins, (n, 3) or (3,) [m], along unit vectors, (n, 3).
        """

    @abstractmethod
    def normal(self, point: Array) -> Array:
        """Unit normals, outward, at points of the surface, (n, 3) -> (n, 3)."""

    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """Share of reflected light at points of the surface, (n, 3) -> (n,): `tone` where nothing is printed on it.

        Edges of a print are blurred over the breadth of a ray [rad] from the eye, (3,).
        """
        return np.full(len(point), self.tone)


@final
@dataclass(frozen=True)
class Floor(Solid):
    """The plane z = height_m."""

    height_m: float = 0.0
    tone: NotNegative = 0.45

    def hit(self, origin: Array, direction: Array) -> Array:
        """From either side."""
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (self.height_m - origin[..., 2]) / direction[..., 2]
        return np.where(distance > 0, distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Up."""
        return np.broadcast_to(UP, point.shape)


@final
@dataclass(frozen=True)
class Sphere(Solid):
    """A ball."""

    centre_m: Vector
    radius_m: Positive
    tone: NotNegative = 0.7

    def hit(self, origin: Array, direction: Array) -> Array:
        """From outside."""
        towards = np.array(self.centre_m) - origin
        along = np.einsum("...i,...i->...", direction, towards)
        miss2 = np.einsum("...i,...i->...", towards, towards) - along**2
        distance = along - np.sqrt(np.maximum(self.radius_m**2 - miss2, 0.0))
        return np.where((miss2 < self.radius_m**2) & (distance > 0), distance, np.inf)

    def normal(self, point: Array) -> Array:
        """Away from the centre."""
        return np.asarray((point - np.array(self.centre_m)) / self.radius_m)


@final
@dataclass(frozen=True)
class Cuboid(Solid):
    """A cuboid: on a floor its top is a step."""

    origin_m: Vector  # the middle of its underside
    size_m: tuple[Positive, Positive, Positive]  # along its x, y and z
    quat: Quaternion = (0.0, 0.0, 0.0, 1.0)  # its rotation (x, y, z, w)
    tone: NotNegative = 0.6

    def hit(self, origin: Array, direction: Array) -> Array:
        """Slab by slab, from outside."""
        start, along = (self._turn.T @ rays.T for rays in (origin - np.array(self.origin_m), direction))
        enter, leave = np.full(len(direction), -np.inf), np.full(len(direction), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for i, (low, high) in enumerate(zip(*self._bounds, strict=True)):
                one, other = (low - start[i]) / along[i], (high - start[i]) / along[i]
                enter, leave = np.fmax(enter, np.fmin(one, other)), np.fmin(leave, np.fmax(one, other))
        return np.where((enter <= leave) & (enter > 0), enter, np.inf)

    def normal(self, point: Array) -> Array:
        """Normals of the nearest face."""
        inside = (point - np.array(self.origin_m)) @ self._turn
        depth = np.concatenate([np.abs(inside - bound) for bound in self._bounds], axis=-1)
        return np.asarray(np.concatenate([-self._turn.T, self._turn.T])[depth.argmin(axis=-1)])

    @property
    def _turn(self) -> Array:
        return np.asarray(Rotation.from_quat(self.quat).as_matrix())

    @property
    def _bounds(self) -> tuple[Array, Array]:
        """Least and greatest coordinates in its own frame, (3,) each."""
        x, y, z = self.size_m
        return np.array([-x / 2, -y / 2, 0.0]), np.array([x / 2, y / 2, z])


@final
@dataclass(frozen=True, eq=False)
class PrintedBoard(Solid):
    """A thin plate with a checkerboard, with or without markers, and a light border around it.

    In its frame the origin is the inner corner whose outward diagonal square is dark, x runs along the columns, y along
    the rows, z into the board.
    """

    T_base_board: Array  # (4, 4)
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
        """Albedo of paper or ink, mixed in pixels that see both."""
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
        return np.asarray(PAPER + (INK - PAPER) * ink * printed)
