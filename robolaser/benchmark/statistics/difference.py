"""Probability that a run of one algorithm is better than one of another, and tests of such differences.

Runs with one seed share at best their first candidates, and in many algorithms not even these: too little for a paired
test. So all runs of one are compared with all of the other rather than seed by seed. The result for a pair does not
depend on other algorithms, unlike tests on mean ranks: Benavoli, Corani & Mangili 2016.
"""

from itertools import combinations

import numpy as np
from scipy.stats import mannwhitneyu, norm

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.intervals import CONFIDENCE, Intervals

LEVEL = 0.05
"""Adjusted p below which two solvers differ significantly. In at most one of twenty benchmarks of equal solvers a pair
differs significantly over a whole family in one measure; the same holds for all pairs on its single problems."""
MOST_SEEDS = 100  # largest number of seeds that is recommended


def superiority(outcomes: Array) -> Intervals:
    """A12 of each pair of algorithms, the mean over problems where both have runs, outcomes (p, a, s) -> (a, a).

    Probability that a run of one is better than a run of the other, with ties as half, NaN without runs: Vargha &
    Delaney 2000; Arcuri & Briand 2011 recommend it with every test of randomised algorithms. The interval on each
    problem is Newcombe's fifth (2006), which unlike a bootstrap's does not shrink to a point where one algorithm always
    wins; that of the mean is combined from these: Zou & Donner 2008 (MOVER).
    """
    one, other = outcomes[:, :, None, :, None], outcomes[:, None, :, None, :]
    won = (one < other).sum(axis=(3, 4)) + 0.5 * (one == other).sum(axis=(3, 4))
    runs = (~np.isnan(outcomes)).sum(axis=2)
    n, m = runs[:, :, None], runs[:, None]
    value = np.ma.masked_invalid(won / np.where(n * m > 0, n * m, np.nan))
    mean, count = value.mean(axis=0), value.count(axis=0)
    below, above = (np.sqrt(((_bound(value.data, n, m, end) - value) ** 2).sum(axis=0)) / count for end in (0.0, 1.0))
    found = mean, np.maximum(mean - below, 0.0), np.minimum(mean + above, 1.0)
    return Intervals(*(np.asarray(np.ma.filled(one, np.nan)) for one in found))


def rank_sum(outcomes: Array) -> Array:
    """Two-sided p of Mann & Whitney's test of each pair on each problem, (p, a, s) -> (p, a, a).

    Exact unless outcomes are tied; symmetric, NaN on the diagonal and where either has no runs.
    """
    p = np.full((len(outcomes), outcomes.shape[1], outcomes.shape[1]), np.nan)
    for at, of_problem in enumerate(outcomes):
        runs = [row[~np.isnan(row)] for row in of_problem]
        for i, j in combinations(range(len(runs)), 2):
            if len(runs[i]) and len(runs[j]):
                p[at, i, j] = p[at, j, i] = _rank_sum(runs[i], runs[j])
    return p


def stratified(outcomes: Array) -> Array:
    """Two-sided p of each pair over all problems together, none compared with another, (p, a, s) -> (a, a).

    Van Elteren 1960: rank sums of the problems, weighted for the greatest power, with correction for ties and
    continuity. For one problem it is Mann & Whitney's test. Symmetric, NaN on the diagonal and where no
    problem has runs of both.
    """
    there = ~np.isnan(outcomes).all(axis=(1, 2))
    if there.sum() == 1:
        return np.asarray(rank_sum(outcomes[there])[0])
    algorithms = outcomes.shape[1]
    p = np.full((algorithms, algorithms), np.nan)
    for i, j in combinations(range(algorithms), 2):
        both = [(x[~np.isnan(x)], y[~np.isnan(y)]) for x, y in outcomes[:, (i, j)]]
        both = [(x, y) for x, y in both if len(x) and len(y)]
        if both:
            p[i, j] = p[j, i] = _van_elteren(both)
    return p


def smallest(runs: int, problems: int) -> float:
    """P if all runs of one algorithm are better than all of another, with so many runs each on each problem."""
    return float(stratified(np.tile(np.arange(2.0 * runs).reshape(2, runs), (problems, 1, 1)))[0, 1])


def fewest_runs(problems: int, comparisons: int) -> int | None:
    """Runs of each on each problem with which the largest possible difference is significant after Holm's correction.

    None if `MOST_SEEDS` are too few.
    """
    enough = (n for n in range(1, MOST_SEEDS + 1) if comparisons * smallest(n, problems) < LEVEL)
    return next(enough, None)


def holm(p: Array) -> Array:
    """P after correction for all comparisons, which limits the probability of any wrong one. Holm 1979.

    NaN is no comparison; each comparison counts once: give an upper triangle, not a symmetric matrix.
    """
    adjusted = np.full(p.shape, np.nan)
    made = np.flatnonzero(~np.isnan(p))
    order = made[np.argsort(p.flat[made])]
    corrected = p.flat[order] * np.arange(len(order), 0, -1)
    adjusted.flat[order] = np.minimum(np.maximum.accumulate(corrected), 1.0)
    return adjusted


def holm_pairs(p: Array) -> Array:
    """The same of symmetric matrices (..., a, a), each pair counted once."""
    upper = np.triu(np.ones(p.shape[-2:], dtype=bool), 1)
    adjusted = holm(np.where(upper, p, np.nan))
    return np.where(upper, adjusted, np.swapaxes(adjusted, -1, -2))


def _bound(value: Array, n: Ints, m: Ints, end: float) -> Array:
    """Bound of A12 of n and m runs at `CONFIDENCE`, between the estimate and an end of the scale."""
    z = norm.ppf(0.5 + CONFIDENCE / 2)
    others, pairs = (n + m) / 2 - 1, np.where(n * m > 0, n * m, 1)
    outside, inside = np.full_like(value, end), value
    for _ in range(50):  # bisections: to the last digit
        middle = (outside + inside) / 2
        spread = 1 + others * ((1 - middle) / (2 - middle) + middle / (1 + middle))
        far = (value - middle) ** 2 > z**2 * middle * (1 - middle) * spread / pairs
        outside, inside = np.where(far, middle, outside), np.where(far, inside, middle)
    return inside


def _rank_sum(one: Array, other: Array) -> float:
    tied = len(np.unique(np.concatenate([one, other]))) < len(one) + len(other)
    p = float(mannwhitneyu(one, other, method="asymptotic" if tied else "exact").pvalue)
    return 1.0 if np.isnan(p) else p  # SciPy from 1.18 on: NaN where all runs are tied


def _van_elteren(pairs: list[tuple[Array, Array]]) -> float:
    excess, variance, step = 0.0, 0.0, 0.0
    for one, other in pairs:
        n, m = len(one), len(other)
        total = n + m
        weight = 1.0 / (total + 1)
        u = (one[:, None] < other).sum() + 0.5 * (one[:, None] == other).sum()
        alike = np.unique(np.concatenate([one, other]), return_counts=True)[1].astype(float)
        ties = float((alike**3 - alike).sum()) / (total * (total - 1))
        excess += weight * (float(u) - n * m / 2)
        variance += weight**2 * n * m / 12 * (total + 1 - ties)
        step = max(step, weight / 2)
    if variance < 1e-12:
        return 1.0  # all tied
    return float(2 * norm.sf(max(abs(excess) - step, 0.0) / np.sqrt(variance)))
