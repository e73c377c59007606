"""Lenses whose radial distortion one term cannot describe."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import free_radial_term

CORNER_M = 3e-3  # R: the corner of a usual image sensor


@final
@dataclass(frozen=True)
class RadialDistortion(Effect):
    r"""The first radial term that the model does not have, after its k the fifth order's: :math:`u' = u (1 + k_2 r^4)`.

    r is the distance from the principal point. Where a camera's own k2 is fitted, but not its k3, the term is of the
    order above, :math:`k_2 r^6 / R^2` with R = 3 mm, so that k_2 is of the same size.
    """

    name = "radial_distortion"
    title = "a higher radial term than the model's k"
    clause = "the lens has more radial distortion than the model"
    caveat = "valid where points were seen, not in the image's corners"
    remedy = "Use the lens as found here: `camera.yaml` has it."
    reference = "Tsai 1987, A versatile camera calibration technique, eq. 5; Brown 1971"
    stage = Stage.IMAGE
    cause = "camera"
    site = "camera"
    needs = (free_radial_term,)

    k_2: Array = parameter(unit="1/m⁴", bound=3e8, prior_scale=1e7)

    def apply(self, image: Array, run: Run, /) -> Array:
        """Stretch the image, most at its corners: 0.3 px at 3 mm for the typical size and pixels of 7.4 µm."""
        r2 = image[..., :1] ** 2 + image[..., 1:] ** 2
        higher = np.where(run.fitted_k2[:, None], r2 / CORNER_M**2, 1.0)
        return image * (1.0 + self.k_2[:, None, None] * r2**2 * higher)
