"""A camera as it was built: which way each of its pixels looks, which pixel shows a point, how bright light appears."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array
from robolaser.data.toml_schema import NotNegative, Positive
from robolaser.trials.synthetic.scanner import Lens, ScannerOptics

UNTIL = (cv2.TERM_CRITERIA_MAX_ITER, 20, 0.0)
"""Turns of the fixed point that takes the distortion off: to a millionth of a pixel, for k1 down to -0.3."""


@final
@dataclass(frozen=True)
class CameraSettings:
    """What the camera makes of light.

    Attributes:
        ambient_grey: Of white paper in the room's light.
        noise_grey: Standard deviation of the noise at middle grey; half its variance is the light's own.
        blur_px: Standard deviation of the lens's blur.
        exposure: Factor on all light.
        lens_error: What OpenCV's k1 k2 p1 p2 k3 are beyond those of the fourteen numbers.
    """

    ambient_grey: NotNegative = 110.0
    noise_grey: NotNegative = 2.0
    blur_px: NotNegative = 0.6
    exposure: Positive = 1.0
    lens_error: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, eq=False)
class CameraModel:
    """The camera of a stripe scanner.

    Attributes:
        optics: The fourteen numbers of the paper and the mount.
        width_px: Columns of the image.
        height_px: Rows.
        settings: What it makes of light.
    """

    optics: ScannerOptics
    width_px: int = 640
    height_px: int = 480
    settings: CameraSettings = CameraSettings()

    @cached_property
    def lens(self) -> Array:
        """OpenCV's k1 k2 p1 p2 k3, (5,)."""
        lens: Array = self.optics.lens + np.array(self.settings.lens_error)
        return lens

    @property
    def pixel_rad(self) -> float:
        """How wide a pixel looks [rad]."""
        f, s_u, s_v = (self.optics.truth[name] for name in ("f", "s_u", "s_v"))
        return float(np.sqrt(s_u * s_v) / f)

    def pixels(self, point: Array) -> Array:
        """Where points of the camera frame show, (n, 3) [m] -> (n, 2) [px]."""
        return self.optics.pixels(point, Lens(self.lens))

    def rays(self, pixel: Array) -> Array:
        """Which way pixels look, (n, 2) [px] -> unit vectors of the camera frame, (n, 3)."""
        x, y = cv2.undistortPoints(pixel[:, None], self.optics.pinhole, self.lens, criteria=UNTIL)[:, 0].T
        ray = np.stack([y, -x, np.ones_like(x)] if self.optics.stripe_axis == "u" else [x, y, np.ones_like(x)], -1)
        return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))

    @cached_property
    def all_rays(self) -> Array:
        """Of every pixel, row by row, (height * width, 3)."""
        u, v = np.meshgrid(np.arange(self.width_px), np.arange(self.height_px))
        return self.rays(np.stack([u.ravel(), v.ravel()], axis=-1).astype(np.float64))
