"""Light sheets that are bent: a lens off its axis makes a cone of the plane."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.effect import Effect, Scene, parameter
from robolaser.effects.lacking import no_stripe
from robolaser.seams import Seam


@final
@dataclass(frozen=True)
class LaserCurvature(Effect):
    r"""The sheet bulges along the stripe: a point slides on its ray until :math:`n \cdot P = d + (κ + c / z) y^2 / 2`.

    κ is the curvature of a sheet that bulges everywhere alike; c that of a cone, as line lenses throw it, which is the
    flatter the farther from the lens. y is the camera's coordinate along the stripe, n the nominal sheet's normal: turning it by the few degrees that the
    true sheet differs changes κ by as many per cent, and nothing else.
    """

    name: ClassVar[str] = "laser_curvature"
    title: ClassVar[str] = "the sheet is not flat"
    reference: ClassVar[str] = "Isheil et al. 2011, Systematic error correction of a 3D laser scanning device; 0.1 mm"
    seam: ClassVar[Seam] = Seam.LIGHT

    curvature: Array = parameter(unit="1/m", bound=1.0, typical=0.04)
    cone: Array = parameter(unit="", bound=0.5, typical=0.01)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A light sheet."""
        return no_stripe(dataset, "light sheet")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The projector of a stripe scanner."""
        return () if cls.missing(dataset) else ("laser",)

    def bend(self, passing: Array, scene: Scene) -> Array:
        """Slide each point P along its ray to s P, with s = 1 + (κ + c/z) (s y)² / (2 n · P)."""
        theta = scene.dataset.parameters["theta"].nominal
        away = np.cos(theta) * passing[..., 0] + np.sin(theta) * passing[..., 2]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            bulge = self.curvature[:, None] + self.cone[:, None] / passing[..., 2]
            share = bulge * passing[..., 1] ** 2 / (2 * away)
            slide = 2.0 / (1.0 + np.sqrt(np.maximum(1.0 - 4.0 * share, 0.0)))
        return np.asarray(passing * slide[..., None])
