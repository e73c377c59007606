"""A light sheet turned about the optical axis, so that the stripe is not parallel to an image axis."""

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
class LaserRoll(Effect):
    r"""The third freedom of the sheet: :math:`(x \cos γ + y \sin γ) \cos θ + z \sin θ = b \cos θ`."""

    name: ClassVar[str] = "laser_roll"
    title: ClassVar[str] = "the sheet is not parallel to the image's axis"
    reference: ClassVar[str] = "Lee et al. 2004, eqs. 5-6, which take γ = 0"
    stage: ClassVar[Stage] = Stage.SHEET

    angle: Array = parameter(unit="rad", bound=0.5, prior_scale=0.02)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A stripe scanner."""
        return no_stripe(dataset, "light sheet")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The projector of a stripe scanner."""
        return () if cls.missing(dataset) else ("laser",)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Turn each plane's normal about the camera's z axis."""
        cos, sin = np.cos(self.angle)[:, None], np.sin(self.angle)[:, None]
        x, y, z, d = np.moveaxis(value, -1, 0)
        return np.stack([x * cos - y * sin, x * sin + y * cos, z, d], axis=-1)
