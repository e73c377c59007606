"""The convergence trace of one run: when it improved, and to which cost."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
@dataclass(frozen=True, eq=False)
class ConvergenceTrace:
    """Every improvement of a run, in order (k)."""

    evaluations: Ints  # candidates evaluated up to and including the improvement, (k,)
    seconds: Array  # wall time by then [s], (k,)
    costs: Array  # the improved cost, falling, (k,)

    @property
    def final(self) -> float:
        """Lowest cost; infinite if no candidate had a finite one."""
        return float(self.costs[-1]) if len(self.costs) else np.inf

    def first_hits(self, targets: Array) -> tuple[Array, Array]:
        """Evaluations and seconds until costs (t,) were first reached, (t,) each; infinite where they never were."""
        if not len(self.costs):
            return np.full(len(targets), np.inf), np.full(len(targets), np.inf)
        at = np.searchsorted(-self.costs, -targets)  # the first that is no higher
        reached = at < len(self.costs)
        at = np.where(reached, at, 0)
        return np.where(reached, self.evaluations[at], np.inf), np.where(reached, self.seconds[at], np.inf)

    def best_after(self, evaluations: Array) -> Array:
        """Lowest cost after that many evaluations (e,) -> (e,); infinite before the first."""
        return np.append(np.inf, self.costs)[np.searchsorted(self.evaluations, evaluations, side="right")]
