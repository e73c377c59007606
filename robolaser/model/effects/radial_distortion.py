"""Lenses whose radial distortion is more than one term can say."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_stripe
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class RadialDistortion(Effect):
    r"""A term of the fifth order on top of the model's k: :math:`u' = u (1 + k_2 r^4)`, r from the principal point."""

    name: ClassVar[str] = "radial_distortion"
    title: ClassVar[str] = "a higher radial term than the model's k"
    reference: ClassVar[str] = "Tsai 1987, A versatile camera calibration technique, eq. 5; Brown 1971"
    stage: ClassVar[Stage] = Stage.IMAGE

    k_2: Array = parameter(unit="1/m⁴", bound=3e8, prior_scale=1e7)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A camera."""
        return no_stripe(dataset, "camera")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The camera."""
        return () if cls.missing(dataset) else ("camera",)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Stretch the image, most at its corners: 0.3 px at 3 mm for the typical size and pixels of 7.4 µm."""
        r2 = value[..., :1] ** 2 + value[..., 1:] ** 2
        return value * (1.0 + self.k_2[:, None, None] * r2**2)
