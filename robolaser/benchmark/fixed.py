"""What runs reached with a given budget, and what they spent to a given target."""

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import SHOWN
from robolaser.benchmark.standings.table import Measure
from robolaser.benchmark.statistics import running_time
from robolaser.benchmark.statistics.intervals import successes
from robolaser.benchmark.statistics.profiles import after_evaluations, bands

if TYPE_CHECKING:
    import pandas as pd

QUARTILES = np.array([0.25, 0.5, 0.75])


def fixed_budget(
    result: BenchmarkResult, budgets: Sequence[float] | Array, problems: Sequence[ProblemSummary] = ()
) -> "pd.DataFrame":
    """How far above the lowest cost known runs are after so many evaluations.

    Args:
        result: With its runs.
        budgets: Evaluations.
        problems: On which; on all by default.

    Returns:
        A row for each problem, algorithm and budget: `problem`, `algorithm`, `budget`, `runs`, and of the excess, in
        units of the problem's scale, `median`, `lower` and `upper` quartile; infinite where too many found nothing.
    """
    import pandas as pd  # noqa: PLC0415 - a third of a second

    of = defaultdict(list)
    for run in result.runs:
        of[run.problem, run.algorithm].append(run.trace)
    rows = []
    for problem in problems or result.problems:
        for algorithm in result.solvers:
            if traces := of.get((problem.name, algorithm)):
                costs = after_evaluations(traces, np.asarray(budgets, float))
                found = np.full((len(budgets), len(QUARTILES)), np.inf)
                if np.isfinite(problem.best):
                    found = bands(costs, problem.best, problem.scale, QUARTILES).T
                rows += [(problem.name, algorithm, at, len(traces), *row)
                         for at, row in zip(budgets, found, strict=True)]  # fmt: skip
    return pd.DataFrame(rows, columns=["problem", "algorithm", "budget", "runs", "lower", "median", "upper"])


def fixed_target(
    result: BenchmarkResult,
    family: str,
    tolerances: Sequence[float] = SHOWN,
    measure: Measure = "evaluations",
) -> "pd.DataFrame":
    """What runs spent until they were as close as that to the lowest cost known.

    Args:
        result: With its runs.
        family: Of problems.
        tolerances: Of the targets; the nearest of `TOLERANCES` are taken.
        measure: What is counted.

    Returns:
        A row for each problem, algorithm and target: `problem`, `algorithm`, `tolerance`, `runs`, `successes`, and
        `ert`, the expected running time, infinite if no run reached it.
    """
    import pandas as pd  # noqa: PLC0415 - a third of a second

    arrays = result.arrays(family)
    at = [arrays.target(tolerance) for tolerance in tolerances]
    times, totals = arrays.measured(measure)
    expected = running_time.expected(times[..., at], totals)
    reached, runs = successes(np.swapaxes(times[..., at], -1, -2))
    return pd.DataFrame(
        [
            (problem, algorithm, tolerance, runs[p, a, t], reached[p, a, t], expected[p, a, t])
            for p, problem in enumerate(arrays.problems)
            for a, algorithm in enumerate(arrays.algorithms)
            for t, tolerance in enumerate(tolerances)
            if runs[p, a, t]
        ],
        columns=["problem", "algorithm", "tolerance", "runs", "successes", "ert"],
    )
