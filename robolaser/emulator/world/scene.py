"""Images of the emulated camera: solids lit by the room and the laser, and the noise of its sensor."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array, Bools, Image, Ints
from robolaser.data.toml_schema import NotNegative, Positive
from robolaser.emulator.world.solids import Solid
from robolaser.trials.synthetic.scanner import Light, ScannerOptics

LAMP = np.array([0.30, 0.20, 0.93]) / np.linalg.norm([0.30, 0.20, 0.93])
"""Main direction of the room's light, in the base frame."""
FROM_ALL_SIDES = 0.55  # share of diffuse light in the room's light
REACH = 4.5  # standard deviations of the laser plane's thickness beyond which it is dark
AWAY_M = 1e-7  # offset of a ray's origin from its surface
TIE_M = 1e-9  # at smaller distances, the solid listed later is in front
MIDDLE_GREY = 128.0
GRAIN_PX = 0.7  # of the speckle
UNTIL = (cv2.TERM_CRITERIA_MAX_ITER, 20, 0.0)
"""Iterations of the fixed point that removes distortion: to a millionth of a pixel, for k1 down to -0.3."""


@final
@dataclass(frozen=True)
class CameraSettings:
    """Exposure and noise of the camera."""

    ambient_grey: NotNegative = 110.0  # of white paper in the room's light
    noise_grey: NotNegative = 2.0  # at middle grey, one standard deviation; half its variance is the light's
    blur_px: NotNegative = 0.6  # standard deviation of the lens's blur


@final
@dataclass(frozen=True, eq=False)
class CameraModel:
    """The true camera: directions of pixels, projection of points, and response to light."""

    optics: ScannerOptics  # the fourteen numbers of the paper and the mount
    lens: Array  # OpenCV's k1 k2 p1 p2 k3, (5,)
    width_px: int = 640
    height_px: int = 480
    settings: CameraSettings = CameraSettings()

    @property
    def pixel_rad(self) -> float:
        """Angle of view of a pixel [rad]."""
        f, s_u, s_v = (self.optics.truth[name] for name in ("f", "s_u", "s_v"))
        return float(np.sqrt(s_u * s_v) / f)

    def rays(self, pixel: Array) -> Array:
        """Directions of pixels, (n, 2) [px] -> unit vectors of the camera frame, (n, 3)."""
        x, y = cv2.undistortPoints(pixel[:, None], self.optics.pinhole, self.lens, criteria=UNTIL)[:, 0].T
        ray = np.stack([y, -x, np.ones_like(x)] if self.optics.stripe_axis == "u" else [x, y, np.ones_like(x)], -1)
        return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))

    @cached_property
    def all_rays(self) -> Array:
        """Directions of all pixels, row by row, (height * width, 3)."""
        u, v = np.meshgrid(np.arange(self.width_px), np.arange(self.height_px))
        return self.rays(np.stack([u.ravel(), v.ravel()], axis=-1).astype(np.float64))


@final
@dataclass(frozen=True)
class Projector:
    """The laser: a plane of light in the camera frame, with a Gaussian profile."""

    power_grey: Positive = 260.0  # of its middle on white paper that faces it, at the distance
    width_m: Positive = 0.4e-3  # standard deviation of its thickness
    distance_m: Positive = 0.33  # from the projector; nearer points are brighter
    speckle: NotNegative = 0.1  # its contrast: standard deviation over mean

    def grey(self, point: Array, light: Light) -> Array:
        """Grey of white paper that faces the laser at points of the camera frame, (n, 3) -> (n,)."""
        away = np.linalg.norm(point - light.source, axis=-1)
        grey: Array = self.power_grey * self.distance_m / away * np.exp(-0.5 * (light.off(point) / self.width_m) ** 2)
        return grey


@final
@dataclass(frozen=True)
class RenderedScene:
    """Solids in front of a camera with a laser."""

    solids: tuple[Solid, ...]  # in the base frame; where two coincide, the later one is on top
    eye: CameraModel
    light: Light | None  # the laser plane, in the camera frame; None: there is no laser
    projector: Projector = Projector()  # its brightness

    def cast(self, origin: Array, direction: Array) -> tuple[Array, Ints]:
        """Find the first solids on rays from origins, (n, 3) or (3,) [m], along unit vectors, (n, 3).

        Returns:
            Distances, (n,) [m], inf where there is no solid; indices of the solids, (n,), -1 for none.
        """
        nearest, index = np.full(len(direction), np.inf), np.full(len(direction), -1)
        for i, solid in enumerate(self.solids):
            distance = solid.hit(origin, direction)
            before = (distance <= nearest + TIE_M) & (distance < np.inf)
            nearest[before], index[before] = distance[before], i
        return nearest, index

    def reaches(self, point: Array, normal: Array, source: Array) -> Bools:
        """Whether light from a source reaches points of surfaces with these normals, (n, 3) -> (n,)."""
        towards = source - point
        far = np.linalg.norm(towards, axis=-1)
        direction = towards / far[:, None]
        free: Bools = np.einsum("ij,ij->i", direction, normal) > 0
        for solid in self.solids:
            free &= solid.hit(point + AWAY_M * normal, direction) > far - 2 * AWAY_M
        return free

    def render(self, T_base_camera: Array) -> tuple[Array, Array]:
        """Light that falls on the sensor, (4, 4) -> (height, width) each.

        Returns:
            The room's, 1 for white paper under the lamp, and the laser's when it is on [grey].
        """
        turn, centre = T_base_camera[:3, :3], T_base_camera[:3, 3]
        direction = self.eye.all_rays @ turn.T
        distance, index = self.cast(centre, direction)
        room, laser = np.zeros(len(index)), np.zeros(len(index))
        for i, solid in enumerate(self.solids):
            own = np.flatnonzero(index == i)
            point = centre + distance[own, None] * direction[own]
            normal, albedo = solid.normal(point), solid.albedo(point, centre, self.eye.pixel_rad)
            room[own] = albedo * (FROM_ALL_SIDES + (1.0 - FROM_ALL_SIDES) * np.maximum(normal @ LAMP, 0.0))
            if self.light is not None:
                laser[own] = albedo * self._from_laser(self.light, point, normal, T_base_camera)
        return self._imaged(room), self._imaged(laser)

    def expose(self, room: Array, laser: Array, *, rng: np.random.Generator, grain: np.random.Generator) -> Image:
        """Expose both lights, (height, width); `grain` draws the speckle, which is constant while nothing moves."""
        spread = np.sqrt(np.log1p(self.projector.speckle**2))
        field = cv2.GaussianBlur(grain.standard_normal(laser.shape, dtype=np.float32), (0, 0), GRAIN_PX)
        speckled = laser * np.exp(spread / field.std() * field - spread**2 / 2)
        grey = self.eye.settings.ambient_grey * room + speckled
        variance = 0.5 * self.eye.settings.noise_grey**2 * (1.0 + grey / MIDDLE_GREY)
        grey += np.sqrt(variance) * rng.standard_normal(grey.shape, dtype=np.float32)
        return np.asarray(np.clip(np.rint(grey), 0, 255), dtype=np.uint8)

    def _from_laser(self, light: Light, point: Array, normal: Array, T_base_camera: Array) -> Array:
        """Grey of white paper in the laser's direct light at points of surfaces in the base frame, (n, 3) -> (n,)."""
        turn, centre = T_base_camera[:3, :3], T_base_camera[:3, 3]
        seen, out = (point - centre) @ turn, np.zeros(len(point))
        rows = np.flatnonzero(np.abs(light.off(seen)) < REACH * self.projector.width_m)
        point, normal, source = point[rows], normal[rows], turn @ light.source + centre
        towards = (source - point) / np.linalg.norm(source - point, axis=-1, keepdims=True)
        cosine = np.einsum("ij,ij->i", towards, normal) * self.reaches(point, normal, source)
        out[rows] = cosine * self.projector.grey(seen[rows], light)
        return out

    def _imaged(self, light: Array) -> Array:
        """Light of each pixel, row by row, blurred by the lens, (height, width)."""
        image = light.reshape(self.eye.height_px, self.eye.width_px)
        blur_px = self.eye.settings.blur_px
        return np.asarray(cv2.GaussianBlur(image, (0, 0), blur_px)) if blur_px else image
