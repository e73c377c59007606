"""Light sheets that are bent: a lens off its axis makes a cone of the plane."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_stripe
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class LaserCurvature(Effect):
    r"""The sheet bulges along the stripe: a point slides on its ray until :math:`n \cdot P = d + κ y^2/2 + t(r - s)`.

    κ is the curvature of a sheet that bulges everywhere alike; t = tan(cone) that of a cone, as line lenses throw it: r
    and s are the distances from the projector to the point and to the stripe's middle beside it. y is the camera's
    coordinate along the stripe, n the nominal sheet's normal: turning it by the few degrees that the true sheet
    differs changes κ by as many per cent, and nothing else.
    """

    name: ClassVar[str] = "laser_curvature"
    title: ClassVar[str] = "the sheet is not flat"
    reference: ClassVar[str] = "Isheil et al. 2011, Systematic error correction of a 3D laser scanning device; 0.1 mm"
    stage: ClassVar[Stage] = Stage.LIGHT

    curvature: Array = parameter(unit="1/m", bound=1.0, prior_scale=0.04)
    cone: Array = parameter(unit="rad", bound=0.3, prior_scale=0.01)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A light sheet."""
        return no_stripe(dataset, "light sheet")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The projector of a stripe scanner."""
        return () if cls.missing(dataset) else ("laser",)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Slide each point P along its ray to σ P, with σ (1 - t (r - s) / n · P) = 1 + κ (σ y)² / (2 n · P)."""
        theta = scene.dataset.parameters["theta"].nominal
        x, y, z = np.moveaxis(value, -1, 0)
        away = np.cos(theta) * x + np.sin(theta) * z
        ahead = np.abs(z / np.cos(theta))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            less = 1.0 - np.tan(self.cone)[:, None] * (np.hypot(ahead, y) - ahead) / away
            bulge = self.curvature[:, None] * y**2 / (2 * away)
            slide = 2.0 / (less + np.sqrt(np.maximum(less**2 - 4.0 * bulge, 0.0)))
        return np.asarray(value * slide[..., None])
