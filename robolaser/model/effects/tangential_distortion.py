"""Lenses whose elements are not centred on one axis."""

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
class TangentialDistortion(Effect):
    r"""Brown's decentring, as the model's k taken off the image as read.

    :math:`u' = u + 2 p_1 u v + p_2 (r^2 + 2 u^2)`, :math:`v' = v + p_1 (r^2 + 2 v^2) + 2 p_2 u v`. To first order these
    are OpenCV's p1 and p2 over -f.
    """

    name: ClassVar[str] = "tangential_distortion"
    title: ClassVar[str] = "decentred lens"
    reference: ClassVar[str] = "Brown 1966, Decentering distortion of lenses"
    stage: ClassVar[Stage] = Stage.IMAGE

    p_1: Array = parameter(unit="1/m", bound=5.0, prior_scale=0.1)
    p_2: Array = parameter(unit="1/m", bound=5.0, prior_scale=0.1)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A camera."""
        return no_stripe(dataset, "camera")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The camera."""
        return () if cls.missing(dataset) else ("camera",)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Shift every image point: 0.4 px at 3 mm for the typical size and pixels of 7.4 µm."""
        u, v = value[..., 0], value[..., 1]
        p_1, p_2 = self.p_1[:, None], self.p_2[:, None]
        r2, uv = u**2 + v**2, 2 * u * v
        shift = [p_1 * uv + p_2 * (r2 + 2 * u**2), p_1 * (r2 + 2 * v**2) + p_2 * uv]
        return value + np.stack(shift, axis=-1)
