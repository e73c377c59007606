"""The known distance that the measurements contradict most."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.estimation.outliers import OUTLIER_SIGMA
from robolaser.model.blocks.blocks import KnownDistances
from robolaser.model.forward_model import Model


@final
@dataclass(frozen=True, eq=False)
class ContradictedDistance:
    """A known distance that differs from the model's by more than its noise."""

    known: KnownDistances
    number: int  # of it, among all known ones
    excess_m: float  # over the model's distance

    @classmethod
    def of(cls, model: Model, x: Array) -> "ContradictedDistance | None":
        """That with the largest residual in a model with parameters x (d,); None if all fit."""
        known = model.known_distances
        if known is None:
            return None
        off_m = known.residuals(model.at(x)[0])[0]
        worst = int(np.abs(off_m).argmax())
        return cls(known, worst, float(off_m[worst])) if abs(off_m[worst]) >= OUTLIER_SIGMA * known.sigma_m else None

    @property
    def ends(self) -> tuple[str, str]:
        """Names of its two points."""
        return self.known.ends[self.number]

    @property
    def key(self) -> str:
        """Its name among parameters that a data set holds, such as `tool.0-1.distance`."""
        owner, *_ = self.known.first[self.number][0].partition(self.ends[0])
        return f"{owner}{'-'.join(self.ends)}.distance"

    @property
    def stated_m(self) -> float:
        """The distance in the data set."""
        return float(self.known.known[self.number])

    def removed_from(self, dataset: Dataset) -> Dataset:
        """A data set in which it is not known."""
        return replace(dataset, distances_m=tuple(one for one in dataset.distances_m if {*one[:2]} != {*self.ends}))

    def in_model(self, model: Model, x: Array) -> float:
        """The distance in a model with parameters x (d,) [m]."""
        return self.stated_m - float(self.known.residuals(model.at(x)[0])[0, self.number])

    def __str__(self) -> str:
        return f"known distance between {' and '.join(self.ends)}"

    @property
    def clause(self) -> str:
        """By how much it differs, as a clause."""
        longer = "longer" if self.excess_m > 0 else "shorter"
        return f"The {self} is {1e3 * abs(self.excess_m):.3g} mm {longer} than in the model"
