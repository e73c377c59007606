"""Laser planes that are curved: a lens off its axis makes a cone of the plane."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter


@final
@dataclass(frozen=True)
class LaserCurvature(Effect):
    r"""The surface bulges along the stripe: a point slides on its ray until :math:`n \cdot P = d + κ y^2/2 + t(r - s)`.

    κ is a uniform curvature; t = tan(cone) describes a cone, as projected by line lenses: r and s are the distances
    from the projector to the point and to the stripe's middle beside it. y is the camera's coordinate along the stripe,
    n the nominal plane's normal: an error of a few degrees in it changes κ by as many per cent, and nothing else.
    """

    name = "laser_curvature"
    title = "the laser plane is not flat"
    clause = "the laser plane is not flat"
    caveat = "valid where the stripe was seen, not beyond"
    remedy = "Use the corrected model: adjusting the projector does not flatten its plane."
    reference = "Isheil et al. 2011, Systematic error correction of a 3D laser scanning device; 0.1 mm"
    stage = Stage.POINTS
    cause = "laser"
    site = "laser"

    curvature: Array = parameter(unit="1/m", bound=1.0, prior_scale=0.04)
    cone: Array = parameter(unit="rad", bound=0.3, prior_scale=0.01)

    def apply(self, point: Array, run: Run, /) -> Array:
        """Slide each point P along its ray to σ P, with σ (1 - t (r - s) / n · P) = 1 + κ (σ y)² / (2 n · P)."""
        theta = run.laser_angle
        x, y, z = np.moveaxis(point, -1, 0)
        away = np.cos(theta) * x + np.sin(theta) * z
        ahead = np.abs(z / np.cos(theta))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            less = 1.0 - np.tan(self.cone)[:, None] * (np.hypot(ahead, y) - ahead) / away
            bulge = self.curvature[:, None] * y**2 / (2 * away)
            slide = 2.0 / (less + np.sqrt(np.maximum(less**2 - 4.0 * bulge, 0.0)))
        slid: Array = point * slide[..., None]
        return slid
