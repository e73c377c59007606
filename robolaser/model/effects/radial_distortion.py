"""Lenses whose radial distortion one term cannot describe."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.compiled_terms import RADIAL
from robolaser.model.effects.effect import Effect, Run, parameter
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class RadialDistortion(Effect):
    r"""A term of the fifth order on top of the model's k: :math:`u' = u (1 + k_2 r^4)`, r from the principal point."""

    name = "radial_distortion"
    title = "a higher radial term than the model's k"
    clause = "the lens has more radial distortion than the model"
    caveat = "valid where the stripe was seen, not in the image's corners"
    remedy = "Use the lens as found here: `camera.yaml` has it."
    reference = "Tsai 1987, A versatile camera calibration technique, eq. 5; Brown 1971"
    stage = Stage.IMAGE
    cause = "camera"
    site = "camera"

    k_2: Array = parameter(unit="1/m⁴", bound=3e8, prior_scale=1e7)

    def apply(self, image: Array, run: Run, /) -> Array:
        """Stretch the image, most at its corners: 0.3 px at 3 mm for the typical size and pixels of 7.4 µm."""
        r2 = image[..., :1] ** 2 + image[..., 1:] ** 2
        return image * (1.0 + self.k_2[:, None, None] * r2**2)

    def compiled_terms(self, run: Run) -> tuple[float, ...]:
        """Its kind and coefficient."""
        return (RADIAL, float(self.k_2[0]), 0.0)
