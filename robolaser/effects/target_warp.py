"""Targets that are not flat."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.effect import Effect, Scene, parameter
from robolaser.effects.lacking import no_flat_target
from robolaser.seams import Seam


@final
@dataclass(frozen=True)
class TargetWarp(Effect):
    """The target's height along its normal is a polynomial of the fourth degree in ξ and η instead of zero.

    ξ and η are the place on the target from the middle of its points, over half their larger extent; ξ runs along the
    frame's x axis as near as the plane lets it (along y on a plane across x). `xxy` is the factor of ξ² η. Height and
    slope of the whole (`z`, `x`, `y`) count because a placed target stands where one part of it says.
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
    z: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    x: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    y: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xxx: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xxy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xyy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    yyy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xxxx: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xxxy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xxyy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    xyyy: Array = parameter(unit="m", bound=0.02, typical=5e-4)
    yyyy: Array = parameter(unit="m", bound=0.02, typical=5e-4)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A target that is flat as given."""
        return no_flat_target(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The target of a stripe scanner."""
        return () if cls.missing(dataset) else ("target",)

    def bend(self, passing: Array, scene: Scene) -> Array:
        """Lift each point along the normal."""
        plane = scene.target
        xi, eta = np.moveaxis((passing - plane.centre) @ plane.axes[:, :2] / plane.half, -1, 0)
        lift = np.zeros_like(xi)
        for name, *_ in self.declared():
            lift = lift + getattr(self, name)[:, None] * xi ** name.count("x") * eta ** name.count("y")
        return np.asarray(passing + lift[..., None] * plane.axes[:, 2])
