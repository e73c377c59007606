"""Targets that are not flat."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.centres import centres
from robolaser.effects.effect import Effect, Scene, parameter, shape
from robolaser.effects.lacking import no_flat_target
from robolaser.seams import Seam


@final
@dataclass(frozen=True)
class TargetWarp(Effect):
    """The target bows along its normal: by xx ξ² + xy ξ η + yy η².

    ξ and η are the place on the target from where it is true, over half the larger extent of its points; ξ runs along
    the frame's x axis as near as the plane lets it (along y on a plane across x). Where the target is true is a shape,
    counted from the middle of the points.
    """

    name: ClassVar[str] = "target_warp"
    title: ClassVar[str] = "the target is not flat"
    reference: ClassVar[str] = (
        "Strobl, Hirzinger 2011, More accurate pinhole camera calibration; 0.1 mm good, 0.5-3 poor"
    )
    seam: ClassVar[Seam] = Seam.TARGET
    looks_around: ClassVar[bool] = True

    xx: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    yy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    centre_x: Array = shape(unit="m", lower=-2.0, upper=2.0, nominal=0.0)
    centre_y: Array = shape(unit="m", lower=-2.0, upper=2.0, nominal=0.0)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A target that is flat as given."""
        return no_flat_target(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The target of a stripe scanner."""
        return () if cls.missing(dataset) else ("target",)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """The middle and places around it."""
        return centres(Scene.of(dataset).target.half)

    def bend(self, passing: Array, scene: Scene) -> Array:
        """Lift each point along the normal."""
        plane = scene.target
        centre = np.stack([self.centre_x, self.centre_y], axis=-1)[:, None]
        xi, eta = np.moveaxis(((passing - plane.centre) @ plane.axes[:, :2] - centre) / plane.half, -1, 0)
        lift = self.xx[:, None] * xi**2 + self.xy[:, None] * xi * eta + self.yy[:, None] * eta**2
        return np.asarray(passing + lift[..., None] * plane.axes[:, 2])
