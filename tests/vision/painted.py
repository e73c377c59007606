"""Images of a checkerboard on a plate with a laser line, by ray casting; shares no code with the detection."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

WIDTH, HEIGHT = 640, 480
FOCAL = 800.0
CENTRE = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
SHEET_NORMAL = np.array([np.cos(np.radians(30.0)), 0.06, np.sin(np.radians(30.0))])
SHEET_OFFSET = 0.116
SQUARE = 0.010
EDGE = 0.00006
"""Half the width of a printed edge [m], about a third of a pixel, to avoid ragged edges."""


@dataclass(frozen=True)
class Scene:
    """A board before the camera.

    Attributes:
        R: Rotation of the board in the camera, (3, 3).
        t: The board's origin in the camera, (3,) [m].
        columns: Inner corners along x.
        rows: Inner corners along y.
        dark_first: Whether the square outward of the origin is dark.
        plate: Largest y of the plate under the board [m]; beyond it is a floor.
        border: Width of the plate beyond the outer squares [m]; beyond it is the floor.
        floor: Depth of the floor below the plate [m].
        light: Peak of the stripe on white [grey]; above 255 it saturates.
        width: Standard deviation of the laser plane's thickness [m].
        ambient: Grey of white paper without the stripe.
        mirror: Peak of a second, parallel stripe relative to the first.
        noise: Standard deviation of the noise [grey].
        k1: Radial distortion.
    """

    R: np.ndarray
    t: np.ndarray
    columns: int = 7
    rows: int = 6
    dark_first: bool = True
    plate: float = np.inf
    border: float = np.inf
    floor: float = 0.020
    light: float = 1200.0
    width: float = 0.0004
    ambient: float = 45.0
    mirror: float = 0.0
    noise: float = 1.0
    k1: float = -0.08

    def rays(self, pixel: np.ndarray) -> np.ndarray:
        """Viewing directions of pixels (..., 2) with z = 1, (..., 3)."""
        bent = (pixel - CENTRE) / FOCAL
        straight = bent
        for _ in range(12):
            straight = bent / (1 + self.k1 * np.sum(straight**2, axis=-1, keepdims=True))
        return np.concatenate([straight, np.ones_like(straight[..., :1])], axis=-1)

    def project(self, place: np.ndarray) -> np.ndarray:
        """Pixels of points on the board, (..., 2) [m] -> (..., 2) [px]."""
        point = np.concatenate([place, np.zeros_like(place[..., :1])], axis=-1) @ self.R.T + self.t
        straight = point[..., :2] / point[..., 2:]
        return FOCAL * straight * (1 + self.k1 * np.sum(straight**2, axis=-1, keepdims=True)) + CENTRE

    def corners(self) -> np.ndarray:
        """The inner corners, (rows, columns, 2) [px]."""
        x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        return self.project(SQUARE * np.stack([x, y], axis=-1))

    def hit(self, ray: np.ndarray) -> np.ndarray:
        """Intersect rays with the board's plane, (..., 3) in the camera [m]."""
        normal = self.R[:, 2]
        return ray * (normal @ self.t) / (ray @ normal)[..., None]

    def place(self, pixel: np.ndarray) -> np.ndarray:
        """Points on the board's plane at pixels, (n, 2) [m]."""
        return ((self.hit(self.rays(pixel)) - self.t) @ self.R)[:, :2]

    def above_sheet(self, pixel: np.ndarray) -> np.ndarray:
        """Distance from the laser plane of the board's points at pixels (n, 2) [m]."""
        return self.hit(self.rays(pixel)) @ SHEET_NORMAL - SHEET_OFFSET

    def paint(self, seed: int) -> np.ndarray:
        """Render the image, (HEIGHT, WIDTH) uint8, with three by two rays a pixel, blurred by 0.7 px."""
        u, v = _all_rays(self.k1)
        (across, along, normal), sheet = self.R.T.astype(np.float32), SHEET_NORMAL.astype(np.float32)
        far = np.float32(self.R[:, 2] @ self.t)
        depth = 1 / _along(normal, u, v)
        x, y = (
            (far * depth * _along(axis, u, v) - np.float32(axis @ self.t)) / np.float32(SQUARE)
            for axis in (across, along)
        )
        edge = self.border / SQUARE
        on_plate = (x > -1 - edge) & (x < self.columns + edge) & (y > -1 - edge) & (y < self.rows + edge)
        on_plate &= y < self.plate / SQUARE
        inside = (x >= -1) & (x < self.columns) & (y >= -1) & (y < self.rows)
        column, row = np.rint(x), np.rint(y)
        half = (column + row) / 2
        soft = np.clip((x - column) * (SQUARE / EDGE), -1, 1) * np.clip((y - row) * (SQUARE / EDGE), -1, 1)
        soft *= 1 - 4 * (half - np.floor(half))
        dark = inside * (0.5 + (0.5 if self.dark_first else -0.5) * soft)
        paper = np.where(on_plate, 1 - 0.85 * dark, np.float32(0.5))
        reach = np.where(on_plate, far, far + np.float32(self.floor))
        off = reach * depth * _along(sheet, u, v) - np.float32(SHEET_OFFSET)
        light = np.exp(-0.5 * (off / self.width) ** 2)
        if self.mirror:
            light += self.mirror * np.exp(-0.5 * ((off - 0.008) / self.width) ** 2)
        grey = cv2.GaussianBlur(paper * (self.ambient + self.light * light), (0, 0), sigmaX=2.1, sigmaY=1.4)
        pixel = cv2.resize(grey, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float64)
        pixel += self.noise * np.random.default_rng(seed).standard_normal(pixel.shape)
        return np.clip(np.rint(pixel), 0, 255).astype(np.uint8)


def _along(axis: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rays (u, v, 1) along an axis (3,)."""
    return axis[0] * u + axis[1] * v + axis[2]


@cache
def _all_rays(k1: float) -> np.ndarray:
    """Viewing directions of three by two rays a pixel, (2, 2 HEIGHT, 3 WIDTH)."""
    u, v = np.meshgrid((np.arange(3 * WIDTH) + 0.5) / 3 - 0.5, (np.arange(2 * HEIGHT) + 0.5) / 2 - 0.5)
    rays = Scene(np.eye(3), np.zeros(3), k1=k1).rays(np.stack([u, v], axis=-1))[..., :2]
    return np.ascontiguousarray(np.moveaxis(rays, -1, 0), dtype=np.float32)


def scene(tilt_deg: tuple[float, float, float], middle: tuple[float, float, float], **changes: object) -> Scene:
    """A board with its middle at a position in the camera [m], rotated about x, y and z."""
    R = Rotation.from_euler("xyz", tilt_deg, degrees=True).as_matrix()
    size = (changes.get("columns", 7), changes.get("rows", 6))
    half = SQUARE * np.array([size[0] - 1, size[1] - 1, 0]) / 2
    return Scene(R, np.array(middle) - R @ half, **changes)


def session(**changes: object) -> list[Scene]:
    """Five views of one board, enough to estimate the lens."""
    tilts = [(0, 18, 0), (15, 4, 4), (-14, 8, -6), (6, -16, 3), (-8, 14, 9)]
    line_centres = [
        (-0.012, 0, 0.16),
        (-0.014, 0.004, 0.165),
        (-0.016, -0.003, 0.17),
        (-0.02, 0.0, 0.165),
        (-0.013, 0, 0.175),
    ]
    return [scene(tilt, middle, **changes) for tilt, middle in zip(tilts, line_centres, strict=True)]


def written(
    scenes: list[Scene], folder: Path, turn: Callable[[np.ndarray], np.ndarray] = lambda image: image
) -> list[tuple[str, Path]]:
    """Write the scenes' images, each rotated; returns them with their poses."""
    images = []
    for k, one in enumerate(scenes):
        path = folder / f"image{k}.png"
        cv2.imwrite(str(path), turn(one.paint(k)))
        images.append((f"pose{k}", path))
    return images
