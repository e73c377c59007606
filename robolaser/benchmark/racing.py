"""The best of many algorithms or settings, without running the hopeless ones to the end: iterated F-race.

Seed by seed, whoever ranks significantly worse than the best so far is dropped. Birattari, Stützle, Paquete &
Varrentrapp 2002, "A racing algorithm for configuring metaheuristics". Where settings come from ranges, further races
follow, of the best and of new settings near them: irace (López-Ibáñez et al. 2016).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2, rankdata, t

from robolaser.arrays import Array, Bools
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import HEADLINE
from robolaser.benchmark.setting_space import SettingSpace
from robolaser.benchmark.solvers import find
from robolaser.benchmark.statistics.difference import holm_pairs
from robolaser.benchmark.statistics.ranks import complete, outcomes
from robolaser.benchmark.table import RunTable

LEVEL = 0.05
"""Of the tests after each seed, as in irace; over the seeds there is no correction."""
FIRST = 5
"""Seeds before anybody is dropped, as in irace."""


def race(plan: RunPlan, table: RunTable, space: SettingSpace | None = None) -> Iterator[RunPlan]:
    """Plans of a race, the runs of each of which have to be in the table before the next is asked for.

    The plan says who races and on how many seeds at most; further settings come from a space.
    """
    left, most, furthest = [solver.name for solver in plan.solvers], len(plan.seeds), 0
    for number in range(space.rounds if space is not None else 1):
        if space is not None and number:
            plan = _without(plan, left[space.rounds :], furthest)
            left = left[: space.rounds]
            new = [find(name) for name in space.near(left, max(space.samples - len(left), 1), number)]
            plan = replace(plan, solvers=(*plan.solvers, *new))
            left += [solver.name for solver in new]
        for count in range(min(FIRST, most), most + 1):
            stage, furthest = replace(plan, seeds=plan.seeds[:count]), max(furthest, count)
            yield stage
            blocks = _blocks(table.result(stage), left)
            stays = survivors(blocks)
            plan = _without(plan, [name for name, stay in zip(left, stays, strict=True) if not stay], count)
            left = [left[a] for a in np.argsort(rankdata(blocks, axis=1).sum(axis=0), kind="stable") if stays[a]]
            if len(left) == 1:
                break
    yield replace(plan, seeds=plan.seeds[:furthest])


def _without(plan: RunPlan, names: Sequence[str], count: int) -> RunPlan:
    return replace(plan, dropped={**plan.dropped, **dict.fromkeys(names, count)})


def survivors(blocks: Array, level: float = LEVEL) -> Bools:
    """Who is not significantly worse than the best, outcomes of blocks (b, a) -> (a,), lower is better.

    Friedman's test, then Conover's of each pair (1999, section 5.8), both at one level. Holm's correction is for all
    pairs, since who is best is seen in the same blocks; irace corrects its t-test so, and its Friedman test not at all.
    """
    n, k = blocks.shape
    stay = np.ones(k, dtype=bool)
    if n < 2 or k < 2:
        return stay
    ranks = rankdata(blocks, axis=1)
    sums, squares = ranks.sum(axis=0), (ranks**2).sum()
    spread = squares - n * k * (k + 1) ** 2 / 4
    if spread <= 0 or chi2.sf((k - 1) * ((sums - n * (k + 1) / 2) ** 2).sum() / spread, k - 1) >= level:
        return stay  # all tied, or as good as that
    freedom = (n - 1) * (k - 1)
    error = max(2 * (n * squares - (sums**2).sum()) / freedom, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = 2 * t.sf(np.abs(sums[:, None] - sums) / np.sqrt(error), freedom)
    worse: Bools = holm_pairs(np.nan_to_num(p, nan=1.0))[sums.argmin()] < level
    return ~worse


def _blocks(result: BenchmarkResult, names: Sequence[str]) -> Array:
    """Outcomes of all algorithms where each has a run, (problem and seed, a)."""
    found = [np.empty((0, len(names)))]
    for family in result.families:
        arrays = result.arrays(family)
        if set(names) <= set(arrays.algorithms):
            came = outcomes(arrays.evaluations[..., arrays.target(HEADLINE)], arrays.final)
            found.append(complete(came[:, [arrays.algorithms.index(name) for name in names]]))
    return np.concatenate(found)
