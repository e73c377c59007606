"""The best of many algorithms or settings, without running the hopeless ones to the end: F-race.

Seed by seed, whoever ranks significantly worse than the best so far is dropped. Birattari, Stützle, Paquete &
Varrentrapp 2002, "A racing algorithm for configuring metaheuristics"; it is the elimination of irace (López-Ibáñez et
al. 2016), without its sampling of new settings.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.stats import chi2, rankdata, t

from robolaser.arrays import Array, Bools
from robolaser.benchmark.defaults import BUDGET, SEEDS
from robolaser.benchmark.engines import Engine, ThisMachine
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import HEADLINE
from robolaser.benchmark.run_loop import fill
from robolaser.benchmark.statistics.mean_ranks import complete
from robolaser.benchmark.statistics.outcome import outcomes
from robolaser.benchmark.table import RunTable

LEVEL = 0.05
"""Of the tests, as in irace. Repeated after each seed without correction: a race screens, it proves nothing."""
FIRST = 5
"""Seeds before anybody is dropped, as in irace."""


@final
@dataclass(frozen=True, eq=False)
class Race:
    """How a race ended.

    Attributes:
        left: Algorithms that were not dropped, the best mean rank first.
        dropped: After how many seeds the others were.
        runs: Runs that were made.
    """

    left: tuple[str, ...]
    dropped: Mapping[str, int]
    runs: int


def race(
    problems: Sequence[object],
    algorithms: Sequence[str],
    *,
    seeds: int = SEEDS,
    first: int = FIRST,
    budget: int = BUDGET,
    engine: Engine | None = None,
) -> Race:
    """Race algorithms against each other until one is left or seeds are used up.

    Args:
        problems: As in `RunPlan.of`.
        algorithms: Names with settings, as `rcga:b=2`.
        seeds: Most of them.
        first: Seeds before anybody is dropped.
        budget: Evaluations of a run.
        engine: Where the runs are made; on all cores of this machine by default.

    Raises:
        UsageError: There is no such problem, algorithm or setting.
    """
    left = list(dict.fromkeys(algorithms))
    dropped: dict[str, int] = {}
    with engine or ThisMachine() as used, RunTable() as table:
        for count in range(min(first, seeds), seeds + 1):
            plan = RunPlan.of(problems, left, seeds=count, budget=budget)
            fill(table, plan, used)
            blocks = _blocks(table.result(plan), left)
            stays = survivors(blocks)
            dropped |= {name: count for name, stay in zip(left, stays, strict=True) if not stay}
            order = np.argsort(rankdata(blocks, axis=1).sum(axis=0), kind="stable")
            left = [left[a] for a in order if stays[a]]
            if len(left) == 1:
                break
        return Race(tuple(left), dropped, len(table))


def survivors(blocks: Array, level: float = LEVEL) -> Bools:
    """Who is not significantly worse than the best: Friedman's test, then Conover's (1999, section 5.8) of each pair.

    Args:
        blocks: Outcomes, lower is better, (b, a).
        level: Of both tests.

    Returns:
        (a,).
    """
    n, k = blocks.shape
    stay = np.ones(k, dtype=bool)
    if n < 2 or k < 2:
        return stay
    ranks = rankdata(blocks, axis=1)
    sums, squares = ranks.sum(axis=0), (ranks**2).sum()
    spread = squares - n * k * (k + 1) ** 2 / 4
    if spread <= 0:  # all tied
        return stay
    friedman = (k - 1) * ((sums - n * (k + 1) / 2) ** 2).sum() / spread
    if chi2.sf(friedman, k - 1) >= level:
        return stay
    freedom = (n - 1) * (k - 1)
    error = max(2 * (n * squares - (sums**2).sum()) / freedom, 0.0)
    close: Bools = sums - sums.min() <= t.ppf(1 - level / 2, freedom) * np.sqrt(error)
    return close


def _blocks(result: BenchmarkResult, names: Sequence[str]) -> Array:
    """Outcomes of all algorithms where each has a run, (problem and seed, a)."""
    found = [np.empty((0, len(names)))]
    for family in result.families:
        arrays = result.arrays(family)
        if set(arrays.algorithms) == set(names):
            came = outcomes(arrays.evaluations[..., arrays.target(HEADLINE)], arrays.final)
            found.append(complete(came)[:, [arrays.algorithms.index(name) for name in names]])
    return np.concatenate(found)
