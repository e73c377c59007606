"""The sheet of light that a line projector throws."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.vectors import dot
from robolaser.trials.synthetic.light import Light


@final
@dataclass(frozen=True)
class LaserSheet:
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
    def surface(self) -> Light:
        """Its middle."""
        return Light(self.b, np.array(self.theta), np.array(self.roll), np.array(self.curvature))

    def on(self, surface: Light) -> "LaserSheet":
        """The same light on another surface."""
        theta, roll, cone = (float(angle) for angle in (surface.theta, surface.roll, surface.cone))
        return replace(self, b=surface.base, theta=theta, roll=roll, curvature=cone)

    @property
    def source(self) -> Array:
        """Where the light comes from, (3,) [m]."""
        return self.surface.source

    @property
    def normal(self) -> Array:
        """Of the flat sheet, (3,)."""
        return self.surface.normals

    def off(self, point: Array) -> Array:
        """Signed distance of points of the camera frame from the sheet's middle, (..., 3) -> (...,) [m]."""
        return self.surface.off(point)

    def grey(self, point: Array) -> Array:
        """Grey of white paper at points of the camera frame that faces the projector, (..., 3) -> (...,)."""
        away = np.sqrt(dot(point - self.source, point - self.source))
        grey: Array = self.power * self.distance_m / away * np.exp(-0.5 * (self.off(point) / self.width_m) ** 2)
        return grey
