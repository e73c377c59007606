"""Standings of solvers, computed from their runs."""

from collections.abc import Mapping

import numpy as np

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import HEADLINE, ResultArrays
from robolaser.benchmark.standings import significance
from robolaser.benchmark.standings.estimates import estimate, quality, violation
from robolaser.benchmark.standings.measurements import Measurements
from robolaser.benchmark.standings.ordering import order
from robolaser.benchmark.standings.table import OnProblem, Reached, Result, Standings
from robolaser.benchmark.statistics import running_time
from robolaser.benchmark.statistics.success import successes, wilson


def standings(result: BenchmarkResult, family: str, *, seed: int = 1) -> Standings:
    """Rank the solvers on a family of problems.

    Args:
        result: With all its runs so far.
        family: Which of its problems.
        seed: Seed of the bootstrap samples.
    """
    return standings_of(result.arrays(family), family=family, refused=result.refused, seed=seed)


def standings_of(
    arrays: ResultArrays, *, family: str, refused: Mapping[tuple[str, str], str], seed: int = 1
) -> Standings:
    """Rank the solvers, given their runs as arrays.

    Args:
        arrays: Runs on the family's problems.
        family: Its name.
        refused: Why a solver does not apply to a problem, by (problem, solver).
        seed: Seed of the bootstrap samples.
    """
    problems = range(len(arrays.problems))
    drawn = running_time.draws(len(problems), len(arrays.seeds), np.random.default_rng(seed))
    evaluations, seconds = Measurements.of(arrays, "evaluations", drawn), Measurements.of(arrays, "seconds", drawn)
    results = _results(arrays, evaluations, seconds)
    return Standings(
        family=family,
        tolerance=HEADLINE,
        seeds=len(arrays.seeds),
        evaluations=order(evaluations, problems, refused),
        seconds=order(seconds, problems, refused),
        by_problem=tuple(
            OnProblem(
                problem=name,
                evaluations=order(evaluations, [p], refused),
                seconds=order(seconds, [p], refused),
                results=results[p],
            )
            for p, name in enumerate(arrays.problems)
        ),
        scope=significance.SCOPE,
    )


def _results(arrays: ResultArrays, evaluations: Measurements, seconds: Measurements) -> list[tuple[Result, ...]]:
    reached, runs = successes(np.moveaxis(arrays.evaluations, 2, 3))
    shares = wilson(reached, runs)

    def targets(p: int, a: int) -> tuple[Reached, ...]:
        return tuple(
            Reached(
                tolerance=float(tolerance),
                successes=int(reached[p, a, t]),
                success=estimate(shares, (p, a, t)),
                evaluations=estimate(evaluations.expected, (p, a, t)),
                seconds=estimate(seconds.expected, (p, a, t)),
            )
            for t, tolerance in enumerate(arrays.tolerances)
        )

    return [
        tuple(
            Result(
                problem=problem,
                algorithm=algorithm,
                runs=int(arrays.there[p, a].sum()),
                failed=int(arrays.failed[p, a].sum()),
                final=quality(arrays.final[p, a]),
                violation=violation(arrays.final[p, a]),
                targets=targets(p, a),
            )
            for a, algorithm in enumerate(arrays.algorithms)
        )
        for p, problem in enumerate(arrays.problems)
    ]
