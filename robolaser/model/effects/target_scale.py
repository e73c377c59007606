"""Printed targets that are larger or smaller than their drawing."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.centres import centres
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_flat_target
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class TargetScale(Effect):
    """The grid's scale, in its plane: P' = P + scale (P - centre) without the part along the normal.

    A grid that was placed by one of its points grows from there. Which it was is not known: the centre is a shape,
    counted along the plane's axes from the middle of the target points.
    """

    name: ClassVar[str] = "target_scale"
    title: ClassVar[str] = "the printed grid's scale"
    reference: ClassVar[str] = "Strobl, Hirzinger 2011, More accurate pinhole camera calibration; printers: up to 1.5 %"
    stage: ClassVar[Stage] = Stage.TARGET
    depends_on_trajectory: ClassVar[bool] = True

    scale: Array = parameter(unit="", bound=0.05, prior_scale=5e-3)
    centre_x: Array = shape(unit="m", lower=-2.0, upper=2.0, nominal=0.0)
    centre_y: Array = shape(unit="m", lower=-2.0, upper=2.0, nominal=0.0)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A flat target."""
        return no_flat_target(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The target of a stripe scanner."""
        return () if cls.missing(dataset) else ("target",)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """The middle and places around it."""
        return centres(Scene.of(dataset).target.half)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Stretch the target in its plane."""
        plane = scene.target
        flat = plane.axes[:, :2]
        centre = np.stack([self.centre_x, self.centre_y], axis=-1)[:, None]
        return np.asarray(value + self.scale[:, None, None] * (((value - plane.centre) @ flat - centre) @ flat.T))
