"""From runs to standings."""

from collections.abc import Mapping

import numpy as np

from robolaser.benchmark.result import Comparison
from robolaser.benchmark.results_array import HEADLINE, Tally
from robolaser.benchmark.standings import judge
from robolaser.benchmark.standings.estimates import estimate, quality
from robolaser.benchmark.standings.evidence import Evidence
from robolaser.benchmark.standings.ordering import order
from robolaser.benchmark.standings.table import OnProblem, Reached, Result, Standings
from robolaser.benchmark.statistics import running_time
from robolaser.benchmark.statistics.success import successes, wilson


def standings(comparison: Comparison, family: str, *, seed: int = 1) -> Standings:
    """How contestants stand on a family of problems.

    Args:
        comparison: With all its runs so far.
        family: Of its problems.
        seed: Of the bootstrap samples.
    """
    return judged(comparison.tally(family), family=family, refused=comparison.refused, seed=seed)


def judged(tally: Tally, *, family: str, refused: Mapping[tuple[str, str], str], seed: int = 1) -> Standings:
    """The same of runs as arrays.

    Args:
        tally: Of the family's problems.
        family: Its name.
        refused: Why a contestant has nothing to say on a problem, by (problem, contestant).
        seed: Of the bootstrap samples.
    """
    problems = range(len(tally.problems))
    drawn = running_time.draws(len(problems), len(tally.seeds), np.random.default_rng(seed))
    evaluations, seconds = Evidence.of(tally, "evaluations", drawn), Evidence.of(tally, "seconds", drawn)
    results = _results(tally, evaluations, seconds)
    return Standings(
        family=family,
        tolerance=HEADLINE,
        seeds=len(tally.seeds),
        evaluations=order(evaluations, problems, refused),
        seconds=order(seconds, problems, refused),
        by_problem=tuple(
            OnProblem(
                problem=name,
                evaluations=order(evaluations, [p], refused),
                seconds=order(seconds, [p], refused),
                results=results[p],
            )
            for p, name in enumerate(tally.problems)
        ),
        scope=judge.SCOPE,
    )


def _results(tally: Tally, evaluations: Evidence, seconds: Evidence) -> list[tuple[Result, ...]]:
    reached, runs = successes(np.moveaxis(tally.evaluations, 2, 3))
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
            for t, tolerance in enumerate(tally.tolerances)
        )

    return [
        tuple(
            Result(
                problem=problem,
                algorithm=algorithm,
                runs=int(tally.there[p, a].sum()),
                failed=int(tally.failed[p, a].sum()),
                final=quality(tally.final[p, a]),
                targets=targets(p, a),
            )
            for a, algorithm in enumerate(tally.algorithms)
        )
        for p, problem in enumerate(tally.problems)
    ]
