"""The course of one run: when it became better, and by how much."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
@dataclass(frozen=True, eq=False)
class Course:
    """Every improvement of a run, in order (k).

    Attributes:
        evaluations: Candidates evaluated up to and with the better one, (k,).
        seconds: Wall time by then, (k,).
        costs: Its cost, falling, (k,).
    """

    evaluations: Ints
    seconds: Array
    costs: Array

    @property
    def final(self) -> float:
        """Lowest cost; infinite where no candidate had a finite one."""
        return float(self.costs[-1]) if len(self.costs) else np.inf

    def first(self, targets: Array) -> tuple[Array, Array]:
        """Evaluations and seconds at which costs (t,) were first reached, (t,) each; infinite where they never were."""
        at = np.searchsorted(-self.costs, -targets)  # the first that is no higher
        reached = at < len(self.costs)
        at = np.where(reached, at, 0)
        if not len(self.costs):
            return np.full(len(targets), np.inf), np.full(len(targets), np.inf)
        return np.where(reached, self.evaluations[at], np.inf), np.where(reached, self.seconds[at], np.inf)

    def after(self, evaluations: Array) -> Array:
        """Lowest cost after so many evaluations (e,) -> (e,); infinite before the first."""
        return np.append(np.inf, self.costs)[np.searchsorted(self.evaluations, evaluations, side="right")]
