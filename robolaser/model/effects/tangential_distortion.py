"""Lenses whose elements are not centred on one axis."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import centred_lens


@final
@dataclass(frozen=True)
class TangentialDistortion(Effect):
    r"""Brown's decentring, taken off the image like the model's k.

    :math:`u' = u + 2 p_1 u v + p_2 (r^2 + 2 u^2)`, :math:`v' = v + p_1 (r^2 + 2 v^2) + 2 p_2 u v`. To first order these
    are OpenCV's p1 and p2 over -f.
    """

    name = "tangential_distortion"
    title = "decentred lens"
    clause = "the lens is decentred"
    remedy = "Use the lens as found here: `camera.yaml` has it."
    reference = "Brown 1966, Decentering distortion of lenses"
    stage = Stage.IMAGE
    cause = "camera"
    site = "camera"
    needs = (centred_lens,)

    p_1: Array = parameter(unit="1/m", bound=5.0, prior_scale=0.1)
    p_2: Array = parameter(unit="1/m", bound=5.0, prior_scale=0.1)

    def apply(self, image: Array, run: Run, /) -> Array:
        """Shift every image point: 0.4 px at 3 mm for the typical size and pixels of 7.4 µm."""
        u, v = image[..., 0], image[..., 1]
        p_1, p_2 = self.p_1[:, None], self.p_2[:, None]
        r2, uv = u**2 + v**2, 2 * u * v
        shift = [p_1 * uv + p_2 * (r2 + 2 * u**2), p_1 * (r2 + 2 * v**2) + p_2 * uv]
        return image + np.stack(shift, axis=-1)
