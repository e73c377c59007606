"""The sheet of light that a line projector throws."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.vectors import dot


@final
@dataclass(frozen=True)
class Sheet:
    """A sheet in the camera frame: x cos θ + z sin θ = b cos θ, rolled about the view, perhaps bent to a cone.

    Attributes:
        b: Where it leaves the projector, on the camera's x axis when it is not rolled [m].
        theta: Its angle [rad].
        roll: About the view [rad].
        curvature: How far its rays stand off the plane [rad]: a rod lens off its axis makes a cone.
        power: Grey of its middle on white paper that faces it, at the distance, exposure 1.
        width_m: Standard deviation of its thickness [m].
        distance_m: From the projector [m]; nearer it is brighter.
    """

    b: float
    theta: float
    roll: float = 0.0
    curvature: float = 0.0
    power: float = 260.0
    width_m: float = 0.4e-3
    distance_m: float = 0.33

    @property
    def source(self) -> Array:
        """Where the light comes from, (3,) [m]."""
        return self.b * np.array([np.cos(self.roll), np.sin(self.roll), 0.0])

    @property
    def normal(self) -> Array:
        """Of the flat sheet, (3,)."""
        cos = np.cos(self.theta)
        return np.array([cos * np.cos(self.roll), cos * np.sin(self.roll), np.sin(self.theta)])

    def off(self, point: Array) -> Array:
        """How far points of the camera frame are from the sheet's middle, with a sign, (..., 3) -> (...,) [m]."""
        ray = point - self.source
        out: Array = ray @ self.normal
        if self.curvature:
            spread = np.sqrt(np.maximum(dot(ray, ray) - out**2, 0.0))
            out = out - np.tan(self.curvature) * spread
        return out

    def grey(self, point: Array) -> Array:
        """Grey of white paper at points of the camera frame that faces the projector, (..., 3) -> (...,)."""
        away = np.sqrt(dot(point - self.source, point - self.source))
        grey: Array = self.power * self.distance_m / away * np.exp(-0.5 * (self.off(point) / self.width_m) ** 2)
        return grey
