"""A camera as it was built: which way each of its pixels looks, and which pixel shows a point."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.vectors import unit
from robolaser.trials.synthetic.scanner import Lens, ScannerOptics

TURNS = 30  # of the fixed point that takes the lens's distortion off: far below a millionth of a pixel


@final
@dataclass(frozen=True, eq=False)
class CameraModel:
    """The camera of a stripe scanner.

    Attributes:
        truth: The paper's fourteen numbers, SI.
        bracket_quat: Turn of the camera on the flange (x, y, z, w), before the small angles.
        angles: "xyz" or "zyz".
        stripe_axis: "u" or "v".
        width_px: Columns of the image.
        height_px: Rows.
        lens_error: What OpenCV's k1 k2 p1 p2 k3 are beyond those of the fourteen numbers.
    """

    truth: Mapping[str, float]
    bracket_quat: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    angles: str = "xyz"
    stripe_axis: str = "v"
    width_px: int = 640
    height_px: int = 480
    lens_error: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def mount(self) -> Array:
        """T_flange_camera, (4, 4)."""
        return self._optics.mount

    @cached_property
    def lens(self) -> Array:
        """OpenCV's k1 k2 p1 p2 k3, (5,)."""
        lens: Array = self._optics.lens + np.array(self.lens_error)
        return lens

    @property
    def matrix(self) -> Array:
        """OpenCV's camera matrix, (3, 3)."""
        f, s_u, s_v, u_0, v_0 = (self.truth[name] for name in ("f", "s_u", "s_v", "u_0", "v_0"))
        return np.array([[f / s_u, 0.0, u_0], [0.0, f / s_v, v_0], [0.0, 0.0, 1.0]])

    @property
    def pixel_rad(self) -> float:
        """How wide a pixel looks [rad]."""
        return float(np.sqrt(self.truth["s_u"] * self.truth["s_v"]) / self.truth["f"])

    def pixels(self, point: Array) -> Array:
        """Where points of the camera frame show, (n, 3) [m] -> (n, 2) [px]."""
        return self._optics.pixels(point, Lens(self.lens))

    def rays(self, pixel: Array) -> Array:
        """Which way pixels look, (..., 2) [px] -> unit vectors of the camera frame, (..., 3)."""
        K = self.matrix
        shown = (pixel - K[:2, 2]) / np.diag(K)[:2]
        x, y = _undistorted(shown[..., 0], shown[..., 1], self.lens)
        one = np.ones_like(x)
        ray = np.stack([y, -x, one] if self.stripe_axis == "u" else [x, y, one], axis=-1)
        return unit(ray)

    @cached_property
    def all_rays(self) -> Array:
        """Of every pixel, (height, width, 3)."""
        return self.rays(np.stack(np.meshgrid(np.arange(self.width_px), np.arange(self.height_px)), axis=-1))

    @cached_property
    def slopes(self) -> tuple[Array, Array]:
        """How all rays change from pixel to pixel, along u and along v, two of (height, width, 3)."""
        return np.gradient(self.all_rays, axis=1), np.gradient(self.all_rays, axis=0)

    @cached_property
    def _optics(self) -> ScannerOptics:
        return ScannerOptics(self.truth, self.bracket_quat, self.angles, self.stripe_axis)


def _undistorted(u: Array, v: Array, lens: Array) -> tuple[Array, Array]:
    """Take OpenCV's distortion off points of the plane z = 1."""
    k1, k2, p1, p2, k3 = lens
    x, y = u, v
    for _ in range(TURNS):
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        du = 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        dv = p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
        x, y = (u - du) / radial, (v - dv) / radial
    return x, y
