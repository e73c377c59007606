"""A line projector and a camera: the pixel of the light on a given surface, in given columns of the image."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import Quaternion, pose

STEP_M = 1e-6  # of finite differences in Newton's method
STEPS = 9


@final
@dataclass(frozen=True)
class Light:
    """The projector's light for each pose (n) or row: a plane, or a cone by a tilted rod lens."""

    base: float  # position of its source on the camera's x axis, without roll [m]
    theta: Array  # angle, (n,) [rad]
    roll: Array  # about the view, (n,) [rad]
    cone: Array  # angle of its rays off the plane, (n,) [rad]

    def of_rows(self, pose: Ints) -> "Light":
        """The light at each row's pose, (m,)."""
        return Light(self.base, self.theta[pose], self.roll[pose], self.cone[pose])

    @property
    def source(self) -> Array:
        """Source of the light, (n, 3) in the camera frame [m]."""
        return self.base * np.stack([np.cos(self.roll), np.sin(self.roll), np.zeros_like(self.roll)], axis=-1)

    @property
    def normals(self) -> Array:
        """Normal of the plane, (n, 3) in the camera frame."""
        cos = np.cos(self.theta)
        return np.stack([cos * np.cos(self.roll), cos * np.sin(self.roll), np.sin(self.theta)], axis=-1)

    def off(self, point: Array) -> Array:
        """Signed distance of points of the camera frame from the light, (n, 3) -> (n,) [m]."""
        ray = point - self.source
        off: Array = np.einsum("...i,...i->...", ray, self.normals)
        if np.any(self.cone):
            spread = np.linalg.norm(ray - off[..., None] * self.normals, axis=-1)
            off = off - np.tan(self.cone) * spread
        return off


@final
@dataclass(frozen=True)
class ScannerOptics:
    """The true stripe scanner."""

    truth: Mapping[str, float]  # the paper's fourteen numbers, SI
    bracket_quat: Quaternion  # turn of the camera on the flange (x, y, z, w), before the small angles
    angles: str  # "xyz" or "zyz"
    stripe_axis: str  # "u" or "v"

    @property
    def mount(self) -> Array:
        """T_flange_camera, (4, 4)."""
        turns = [self.truth[name] for name in ("w", "phi", "psi")]
        turn = Rotation.from_quat(self.bracket_quat) * Rotation.from_euler(self.angles.upper(), turns)
        return pose(turn.as_matrix(), np.array([self.truth[f"t_{axis}"] for axis in "xyz"]))

    def light(self, poses: int) -> Light:
        """A constant plane."""
        flat = np.zeros(poses)
        return Light(self.truth["b"], np.full(poses, self.truth["theta"]), flat, flat)

    @property
    def lens(self) -> Array:
        """OpenCV's k1 k2 p1 p2 k3, (5,), of a lens whose inverse is 1 + k r²: the inverted series."""
        k = self.truth["k"] * self.truth["f"] ** 2
        return np.array([-k, 3 * k**2, 0.0, 0.0, -12 * k**3])

    @property
    def pinhole(self) -> Array:
        """OpenCV's camera matrix, (3, 3) [px]."""
        f, s_u, s_v, u_0, v_0 = (self.truth[name] for name in ("f", "s_u", "s_v", "u_0", "v_0"))
        return np.array([[f / s_u, 0.0, u_0], [0.0, f / s_v, v_0], [0.0, 0.0, 1.0]])

    def pixels(self, point: Array, lens: Array, larger: Array | float = 0.0) -> Array:
        """Project points of the camera frame, (m, 3) [m] -> (m, 2) [px].

        The lens is OpenCV's k1 k2 p1 p2 k3, (5,); the image of each point may be larger by a share, (m,).
        """
        x, y, z = point.T
        seen = np.stack([-y, x, z] if self.stripe_axis == "u" else [x, y, z], axis=-1)
        K = self.pinhole
        shown, _ = cv2.projectPoints(seen, np.zeros(3), np.zeros(3), K, lens)
        centre = K[:2, 2]
        off = np.asarray(shown, dtype=np.float64).reshape(-1, 2) - centre
        return np.asarray(centre + off * np.reshape(1.0 + larger, (-1, 1)))

    def meet(
        self, at: Array, light: Light, shown: Callable[[Array], Array], surface: Callable[[Array], Array], start: Array
    ) -> tuple[Array, Array]:
        """Intersect the light with a surface in given columns of the image, by Newton's method in space.

        Args:
            at: Pixel coordinate along the stripe, (m,) [px].
            light: Of each row (m).
            shown: Projection of points of the camera frame, (m, 3) [m] -> (m, 2) [px].
            surface: Height of points of the camera frame above the surface, (m, 3) -> (m,) [m].
            start: A guess, (m, 3) [m].

        Returns:
            Points in the camera frame, (m, 3) [m], and their pixels, (m, 2) [px]; NaN where there is none.
        """
        along = 0 if self.stripe_axis == "u" else 1
        pitch = self.truth[("s_u", "s_v")[along]] / self.truth["f"]

        def off(point: Array) -> Array:
            column = (shown(point)[:, along] - at) * pitch * np.abs(point[:, 2])
            return np.stack([column, light.off(point), surface(point)], axis=-1)

        point = start
        for _ in range(STEPS):
            here = off(point)
            slopes = np.stack([(off(point + shift) - here) / STEP_M for shift in STEP_M * np.eye(3)], axis=-1)
            point = point - np.linalg.solve(slopes, here[..., None])[..., 0]
        lost = ~(np.abs(off(point)).max(axis=1) < 1e-10) | (point[:, 2] <= 0)
        point = np.where(lost[:, None], np.nan, point)
        return point, np.where(lost[:, None], np.nan, shown(np.where(lost[:, None], start, point)))
