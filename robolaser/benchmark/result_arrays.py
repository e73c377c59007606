"""What every run reached, and after how long, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.benchmark.measures import TOLERANCE, tolerances
from robolaser.benchmark.problem import INFEASIBLE
from robolaser.benchmark.problem_summary import ProblemSummary
from robolaser.benchmark.run import FAILED, BenchmarkRun


@final
@dataclass(frozen=True, eq=False)
class ResultArrays:
    """All runs on some problems as arrays: problems p, algorithms a, seeds s, targets t.

    NaN stands for a run that is missing: not yet made, or the solver does not apply to the problem.

    A failed run counts as if it had spent the budget.
    """

    problems: tuple[str, ...]  # p
    algorithms: tuple[str, ...]  # a
    seeds: tuple[int, ...]  # s
    tolerances: Array  # of the targets, falling, (t,)
    headline: int  # which of them solvers are ranked by
    evaluations: Array  # to each target, infinite where it was not reached, (p, a, s, t)
    total_evaluations: Array  # by the whole run, (p, a, s)
    total_s: Array  # wall time of the whole run [s], (p, a, s)
    final: Array  # tolerance of the lowest cost; infeasible: `INFEASIBLE` times (1 + the violation), (p, a, s)
    failed: Bools  # (p, a, s)
    noisy: Bools  # problems whose runs are ranked by what they returned alone, (p,)

    @classmethod
    def of(
        cls,
        runs: Sequence[BenchmarkRun],
        problems: Sequence[ProblemSummary],
        algorithms: Sequence[str],
        seeds: Sequence[int],
        *,
        target: float | None = None,
    ) -> "ResultArrays":
        """Count the runs on problems of one family; those by other algorithms are left out."""
        aims = tolerances(problems[0].family, target)
        shape = (len(problems), len(algorithms), len(seeds))
        evaluations = np.full((*shape, len(aims)), np.nan)
        total_evaluations, total_s, final = (np.full(shape, np.nan) for _ in range(3))
        failed = np.zeros(shape, dtype=bool)
        names = [problem.name for problem in problems]
        of_problem, of_algorithm, of_seed = (
            {one: i for i, one in enumerate(some)} for some in (names, algorithms, seeds)
        )
        for run in runs:
            if run.problem not in of_problem or run.algorithm not in of_algorithm or run.seed not in of_seed:
                continue
            at = of_problem[run.problem], of_algorithm[run.algorithm], of_seed[run.seed]
            problem = problems[at[0]]
            evaluations[at] = run.trace.first_hits(problem.best + aims * problem.scale)[0]
            failed[at] = run.state == FAILED
            total_evaluations[at] = problem.budget if failed[at] else run.evaluations
            total_s[at] = run.seconds
            found = run.trace.final
            final[at] = (found - problem.best) / problem.scale if np.isfinite(found) else np.inf
            if run.violation and not np.isfinite(found):
                final[at] = INFEASIBLE * (1.0 + run.violation)
        wanted = TOLERANCE if target is None else target
        headline = int(np.argmin(np.abs(np.log(aims / wanted))))
        counted = (aims, headline, evaluations, total_evaluations, total_s, final, failed)
        return cls(tuple(names), tuple(algorithms), tuple(seeds), *counted, np.array([one.noisy for one in problems]))

    @property
    def there(self) -> Bools:
        """Runs that were made, (p, a, s)."""
        there: Bools = ~np.isnan(self.total_s)
        return there
