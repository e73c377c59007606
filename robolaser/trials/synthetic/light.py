"""The light that a line projector throws: a plane, or the cone that a rod lens off its axis makes of it."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
@dataclass(frozen=True)
class Light:
    """One light surface for each pose (n) or row."""

    base: float  # where it leaves the projector, on the camera's x axis when it is not rolled [m]
    theta: Array  # angle, (n,) [rad]
    roll: Array  # about the view, (n,) [rad]
    cone: Array  # how far its rays stand off the plane, (n,) [rad]

    def of_rows(self, pose: Ints) -> "Light":
        """The light at each row's pose, (m,)."""
        return Light(self.base, self.theta[pose], self.roll[pose], self.cone[pose])

    @property
    def source(self) -> Array:
        """Where the light comes from, (n, 3) in the camera frame [m]."""
        return self.base * np.stack([np.cos(self.roll), np.sin(self.roll), np.zeros_like(self.roll)], axis=-1)

    @property
    def normals(self) -> Array:
        """Of the plane, (n, 3) in the camera frame."""
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
