"""What every run reached, and after how long, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.benchmark.problem import INFEASIBLE, ProblemSummary
from robolaser.benchmark.single_run import FAILED, BenchmarkRun

TOLERANCES = 10.0 ** np.arange(4.0, -6.5, -0.5)
"""Targets: excesses over the lowest known cost, in units of the problem's scale. They are half a decade apart, from a
hundred times the best RMS to half a millionth more than it."""
HEADLINE = 1e-2
"""The target by which solvers are ranked: J within one per cent, RMS within half a per cent of the best known."""
SHOWN = (1.0, 1e-2, 1e-6)
"""Targets worth a column: in the right valley, as good as solved, solved."""


def targets(best: float, scale: float) -> Array:
    """Costs to be reached on a problem, falling, (t,)."""
    return best + TOLERANCES * scale


@final
@dataclass(frozen=True, eq=False)
class ResultArrays:
    """All runs on some problems as arrays: problems p, solvers a, seeds s, targets t.

    NaN stands for a run that is missing: not yet made, or the solver does not apply to the problem.

    A failed run counts as if it had spent the budget, and as long as the solver's longest on the problem that did not
    fail, or as the time limit if there is none.
    """

    problems: tuple[str, ...]  # p
    algorithms: tuple[str, ...]  # a
    seeds: tuple[int, ...]  # s
    tolerances: Array  # of the targets, falling, (t,)
    evaluations: Array  # to each target, infinite where it was not reached, (p, a, s, t)
    seconds: Array  # the same in wall time [s]
    total_evaluations: Array  # by the whole run, (p, a, s)
    total_s: Array  # the same in wall time [s]
    final: Array  # tolerance of the lowest cost; infeasible: `INFEASIBLE` times (1 + the violation), (p, a, s)
    failed: Bools  # (p, a, s)

    @classmethod
    def of(
        cls,
        runs: Sequence[BenchmarkRun],
        problems: Sequence[ProblemSummary],
        algorithms: Sequence[str],
        seeds: Sequence[int],
        *,
        budget: float,
        time_limit_s: float,
    ) -> "ResultArrays":
        """Count runs; those on other problems, by other algorithms or with other seeds are left out."""
        shape = (len(problems), len(algorithms), len(seeds))
        evaluations, seconds = (np.full((*shape, len(TOLERANCES)), np.nan) for _ in range(2))
        total_evaluations, total_s, final = (np.full(shape, np.nan) for _ in range(3))
        failed = np.zeros(shape, dtype=bool)
        names = [problem.name for problem in problems]
        of_problem, of_algorithm, of_seed = ({one: i for i, one in enumerate(of)} for of in (names, algorithms, seeds))
        for run in runs:
            if run.problem not in of_problem or run.algorithm not in of_algorithm or run.seed not in of_seed:
                continue
            at = of_problem[run.problem], of_algorithm[run.algorithm], of_seed[run.seed]
            lowest, unit = problems[at[0]].best, problems[at[0]].scale
            evaluations[at], seconds[at] = run.trace.first_hits(targets(lowest, unit))
            failed[at] = run.state == FAILED
            total_evaluations[at] = budget if failed[at] else run.evaluations
            total_s[at] = run.seconds
            found = run.trace.final
            final[at] = (found - lowest) / unit if np.isfinite(found) else np.inf
            if run.violation:
                final[at] = INFEASIBLE * (1.0 + run.violation)
        longest = np.where(failed | np.isnan(total_s), 0.0, total_s).max(axis=2, keepdims=True, initial=0.0)
        total_s = np.where(failed, np.where(longest > 0.0, longest, time_limit_s), total_s)
        there = (TOLERANCES, evaluations, seconds, total_evaluations, total_s, final, failed)
        return cls(tuple(names), tuple(algorithms), tuple(seeds), *there)

    @property
    def there(self) -> Bools:
        """Runs that were made, (p, a, s)."""
        there: Bools = ~np.isnan(self.total_s)
        return there

    def measured(self, measure: Literal["evaluations", "seconds"]) -> tuple[Array, Array]:
        """Running times to each target, (p, a, s, t), and of whole runs, (p, a, s), in one measure."""
        return (self.evaluations, self.total_evaluations) if measure == "evaluations" else (self.seconds, self.total_s)

    def target(self, tolerance: float) -> int:
        """Which of the targets has that tolerance."""
        return int(np.argmin(np.abs(np.log(self.tolerances / tolerance))))
