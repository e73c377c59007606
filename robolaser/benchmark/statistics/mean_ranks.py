"""Mean ranks over blocks, and which of their differences are significant.

A block is a (problem, seed) in which each algorithm has one run. Friedman 1937; Nemenyi 1963; Demsar 2006, who ranks
over data sets: ranked over seeds of given problems too, the tests speak of new seeds on these problems.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.stats import friedmanchisquare, rankdata, studentized_range

from robolaser.arrays import Array

LEVEL = 0.05
"""Of the critical difference: as everywhere in the field."""


@final
@dataclass(frozen=True, eq=False)
class MeanRanks:
    """Mean ranks of algorithms a.

    Attributes:
        mean: 1 is best, (a,); NaN without blocks.
        blocks: How many.
        statistic: Friedman's, NaN with fewer than three algorithms or two blocks, or where all are tied.
        p: Of Friedman's test, NaN as the statistic.
        critical_difference: Nemenyi's, NaN with fewer than two algorithms or blocks.
        nemenyi: P of each pair, adjusted for all of them, (a, a); NaN as the critical difference.
    """

    mean: Array
    blocks: int
    statistic: float
    p: float
    critical_difference: float
    nemenyi: Array


def complete(outcomes: Array) -> Array:
    """Outcomes (p, a, s) in blocks in which every algorithm has a run, (n, a)."""
    problems, algorithms, seeds = outcomes.shape
    blocks = np.moveaxis(outcomes, 1, 2).reshape(problems * seeds, algorithms)
    whole: Array = blocks[~np.isnan(blocks).any(axis=1)]
    return whole


def mean_ranks(blocks: Array) -> MeanRanks:
    """Rank algorithms within each block and test the means.

    Args:
        blocks: Outcomes without gaps, lower is better, (n, a).
    """
    n, a = blocks.shape
    ranks = rankdata(blocks, axis=1) if n and a else blocks
    mean = ranks.mean(axis=0) if n else np.full(a, np.nan)
    statistic = p = difference = np.nan
    nemenyi = np.full((a, a), np.nan)
    if n >= 2 and a >= 2:
        difference, nemenyi = critical_difference(n, a), _nemenyi(mean, n)
    if n >= 2 and a >= 3 and (ranks != ranks[:, :1]).any():
        statistic, p = (float(value) for value in friedmanchisquare(*blocks.T))
    return MeanRanks(mean, n, statistic, p, difference, nemenyi)


def critical_difference(blocks: int, algorithms: int) -> float:
    """The difference above which mean ranks are significantly different. Demsar 2006, section 3.2.2."""
    q = float(studentized_range.ppf(1 - LEVEL, algorithms, np.inf)) / np.sqrt(2)
    return float(q * np.sqrt(algorithms * (algorithms + 1) / (6 * blocks)))


def groups(mean: Array, critical_difference: float) -> list[tuple[int, ...]]:
    """Largest sets of two or more algorithms no two of which differ by more: the bars of the diagram.

    Args:
        mean: Ranks, (a,).
        critical_difference: Of them; NaN makes no groups.

    Returns:
        Places in `mean`, each set and the sets by rising mean rank.
    """
    order = np.argsort(mean, kind="stable")
    found: list[tuple[int, ...]] = []
    reached = 0
    for begin in range(len(order)):
        end = int(np.searchsorted(mean[order], mean[order[begin]] + critical_difference, side="right"))
        if not np.isnan(critical_difference) and end - begin >= 2 and end > reached:
            found.append(tuple(int(i) for i in order[begin:end]))
            reached = end
    return found


def _nemenyi(mean: Array, blocks: int) -> Array:
    """P of each pair of mean ranks (a,), adjusted for all of them, (a, a). Demsar 2006, section 3.2.2."""
    a = len(mean)
    q = np.abs(mean[:, None] - mean) / np.sqrt(a * (a + 1) / (6 * blocks))
    p: Array = studentized_range.sf(q * np.sqrt(2), a, np.inf)
    return p
