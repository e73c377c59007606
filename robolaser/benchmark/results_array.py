"""What every run reached, and at what price, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.benchmark.single_run import FAILED, Run

TOLERANCES = 10.0 ** np.arange(4.0, -6.5, -0.5)
"""Targets: the lowest known cost, and this much more of it. Half a decade apart, from a hundred times the best RMS to
half a millionth more than it."""
HEADLINE = 1e-2
"""The target by which contestants are ranked: J within one per cent, RMS within half a per cent of the best known."""
SHOWN = (1.0, 1e-2, 1e-6)
"""Targets worth a column: in the right valley, as good as solved, solved."""


def targets(best: float, scale: float) -> Array:
    """Costs to be reached on a problem, falling, (t,)."""
    return best + TOLERANCES * scale


@final
@dataclass(frozen=True, eq=False)
class Tally:
    """All runs on some questions as arrays: questions p, contestants a, seeds s, targets t.

    NaN stands for a run that is not there: not yet made, or the contestant has nothing to say on the question.

    Attributes:
        problems: Names of the questions, p.
        algorithms: Names of the contestants, a.
        seeds: s of them.
        tolerances: Of the targets, falling, (t,).
        evaluations: To each target, infinite where it was not reached, (p, a, s, t).
        seconds: The same in wall time [s].
        spent_evaluations: By the whole run, (p, a, s); a failed one counts as if it had spent the budget.
        spent_s: The same in wall time [s]; a failed one counts as long as the contestant's longest on the problem that
            did not fail, or as the time limit if there is none.
        final: Lowest cost over the best known, less one in units of the problem's scale: its tolerance, (p, a, s).
        failed: Runs that failed, (p, a, s).
    """

    problems: tuple[str, ...]
    algorithms: tuple[str, ...]
    seeds: tuple[int, ...]
    tolerances: Array
    evaluations: Array
    seconds: Array
    spent_evaluations: Array
    spent_s: Array
    final: Array
    failed: Bools

    @classmethod
    def of(
        cls,
        runs: Sequence[Run],
        *,
        problems: Sequence[str],
        algorithms: Sequence[str],
        seeds: Sequence[int],
        best: Sequence[float],
        scale: Sequence[float],
        budget: int,
        time_limit_s: float,
    ) -> "Tally":
        """Count.

        Args:
            runs: Any; those on other problems, by other algorithms or with other seeds are left out.
            problems: Names, p.
            algorithms: Names, a.
            seeds: s of them.
            best: The lowest cost known of each problem, p.
            scale: What tolerances are measured in, in each problem, p.
            budget: Evaluations that a run might spend.
            time_limit_s: Wall time that a run might take [s].
        """
        shape = (len(problems), len(algorithms), len(seeds))
        per_target = (*shape, len(TOLERANCES))
        evaluations, seconds = np.full(per_target, np.nan), np.full(per_target, np.nan)
        spent_evaluations, spent_s, final = (np.full(shape, np.nan) for _ in range(3))
        failed = np.zeros(shape, dtype=bool)
        of_problem = {name: i for i, name in enumerate(problems)}
        of_algorithm = {name: i for i, name in enumerate(algorithms)}
        of_seed = {seed: i for i, seed in enumerate(seeds)}
        for run in runs:
            if run.problem not in of_problem or run.algorithm not in of_algorithm or run.seed not in of_seed:
                continue
            at = of_problem[run.problem], of_algorithm[run.algorithm], of_seed[run.seed]
            lowest, unit = best[at[0]], scale[at[0]]
            evaluations[at], seconds[at] = run.course.first(targets(lowest, unit))
            failed[at] = run.state == FAILED
            spent_evaluations[at] = budget if failed[at] else run.evaluations
            spent_s[at] = run.seconds
            found = run.course.final
            final[at] = (found - lowest) / unit if np.isfinite(found) else np.inf
        longest = np.where(failed | np.isnan(spent_s), 0.0, spent_s).max(axis=2, keepdims=True, initial=0.0)
        spent_s = np.where(failed, np.where(longest > 0.0, longest, time_limit_s), spent_s)
        return cls(
            tuple(problems),
            tuple(algorithms),
            tuple(seeds),
            TOLERANCES,
            evaluations,
            seconds,
            spent_evaluations,
            spent_s,
            final,
            failed,
        )

    @property
    def there(self) -> Bools:
        """Runs that were made, (p, a, s)."""
        there: Bools = ~np.isnan(self.spent_s)
        return there

    def target(self, tolerance: float) -> int:
        """Which of the targets has that tolerance."""
        return int(np.argmin(np.abs(np.log(self.tolerances / tolerance))))
