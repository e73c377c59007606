"""Printed targets that are larger or smaller than their drawing."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.effect import Effect, Scene, parameter
from robolaser.effects.lacking import no_stripe
from robolaser.seams import Seam


@final
@dataclass(frozen=True)
class TargetScale(Effect):
    """The grid's scale: P' = P + scale (P - centre), from the middle of the target points."""

    name: ClassVar[str] = "target_scale"
    title: ClassVar[str] = "the printed grid's scale"
    reference: ClassVar[str] = "Strobl, Hirzinger 2011, More accurate pinhole camera calibration; printers: up to 1.5 %"
    seam: ClassVar[Seam] = Seam.TARGET
    looks_around: ClassVar[bool] = True

    scale: Array = parameter(unit="", bound=0.05, typical=5e-3)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A printed target."""
        return no_stripe(dataset, "printed target")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The target of a stripe scanner."""
        return () if cls.missing(dataset) else ("target",)

    def bend(self, passing: Array, scene: Scene) -> Array:
        """Stretch the target about its middle."""
        return passing + self.scale[:, None, None] * (passing - scene.target.centre)
