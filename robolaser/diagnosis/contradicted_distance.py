"""The known distance that the measurements contradict most."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.diagnosis.cause_words import listed
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.penalties import complexity_penalty
from robolaser.diagnosis.result import Estimate
from robolaser.diagnosis.summary_text import millimetres
from robolaser.estimation.outliers import OUTLIER_SIGMA
from robolaser.model.blocks.blocks import KnownDistances


@final
@dataclass(frozen=True, eq=False)
class ContradictedDistance:
    """A known distance that differs from the model's by more than its noise."""

    known: KnownDistances
    number: int  # of it, among all known ones
    excess_m: float  # over the model's distance

    @classmethod
    def of(cls, fit: Fit) -> "ContradictedDistance | None":
        """That with the largest residual; None if all fit."""
        known = fit.model.known_distances
        if known is None:
            return None
        off_m = known.residuals(fit.model.at(fit.x)[0])[0]
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

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds that it is wrong, against a residual of such a size by noise."""
        return 0.5 * ((self.excess_m / self.known.sigma_m) ** 2 - complexity_penalty(1, 1))

    def removed_from(self, dataset: Dataset) -> Dataset:
        """A data set in which it is not known."""
        return replace(dataset, distances_m=tuple(one for one in dataset.distances_m if {*one[:2]} != {*self.ends}))

    def would_be(self, fit: Fit) -> Estimate:
        """The distance by a fit in which it is not known."""
        values = fit.model.at(fit.x)[0]
        slopes = self.known.jacobian(values, fit.problem.parameters.names)[0, self.number]
        variance = float(slopes @ fit.at.covariance @ slopes)
        return Estimate(
            self.stated_m - float(self.known.residuals(values)[0, self.number]), float(np.sqrt(variance)), "m"
        )

    def __str__(self) -> str:
        return f"known distance between {listed(self.ends)}"

    @property
    def sentence(self) -> str:
        """A sentence on it."""
        longer = "longer" if self.excess_m > 0 else "shorter"
        return f"The {self} is {millimetres(abs(self.excess_m))} {longer} than in the model: measure it again."
