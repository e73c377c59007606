"""Faults of the image: pixels that are far off."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

FAR_PX = (2.0, 40.0)


@final
@dataclass(frozen=True)
class GrossErrors(FaultModel):
    """Glints and lost stripes: the share `size` of the points, or of their shots, is far off."""

    effect: ClassVar[str] = "outliers"
    sizes: ClassVar[tuple[float, float]] = (0.01, 0.06)
    location: ClassVar[str | None] = "image"

    lasting: bool

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Whether all shots of a point are off, or only some."""
        return (bool(rng.random() < 0.5),)

    def shots(self, pixel: Array, shot: Ints, rng: np.random.Generator) -> Array:
        """Off by 2 to 40 pixels, in any direction."""
        points = np.unique(shot)
        hit = np.isin(shot, points[rng.random(len(points)) < self.size])
        if not self.lasting:
            hit = rng.random(len(shot)) < self.size
        group = shot if self.lasting else np.arange(len(shot))
        way = rng.uniform(-np.pi, np.pi, len(shot))[group]
        far = np.exp(rng.uniform(np.log(FAR_PX[0]), np.log(FAR_PX[1]), len(shot)))[group]
        off: Array = pixel + np.where(hit, far, 0.0)[:, None] * np.stack([np.cos(way), np.sin(way)], axis=-1)
        return off
