"""Stripes whose bright centre is not where the sheet's middle falls, on a tilted surface."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_flat_target
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class StripeBias(Effect):
    r"""The pixel across the stripe shifts by :math:`\mathrm{slope} \tan(\mathrm{tilt})`.

    The tilt is the signed angle between the view and the surface's normal, across the stripe, by the nominal model; the
    surface is the plane of the target points.
    """

    name: ClassVar[str] = "stripe_bias"
    title: ClassVar[str] = "the stripe's centre is biased with the tilt of the surface"
    reference: ClassVar[str] = (
        "Feng, Liu, Xi 2001, Analysis of digitizing errors of a laser scanning system; 0.05-0.3 px"
    )
    stage: ClassVar[Stage] = Stage.PIXELS
    depends_on_trajectory: ClassVar[bool] = True

    slope: Array = parameter(unit="px", bound=5.0, prior_scale=0.2)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A stripe on one plane."""
        return no_flat_target(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The projector of a stripe scanner."""
        return () if cls.missing(dataset) else ("laser",)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Shift the coordinate across the stripe."""
        shift = self.slope[:, None] * scene.tilt
        across = np.array([0.0, 1.0] if scene.stripe_axis == "u" else [1.0, 0.0])
        return np.asarray(value + shift[..., None] * across)
