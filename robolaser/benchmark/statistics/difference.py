"""How often is a run of one algorithm better than one of another, and could chance alone have made them so different?

Runs with one seed have at best their first candidates in common, and many algorithms not even these: too little luck to
be taken out. So all runs of the one are compared with all of the other rather than seed by seed. The result for a pair
does not depend on who else takes part, as that of tests on mean ranks does: Benavoli, Corani & Mangili 2016.
"""

from itertools import combinations

import numpy as np
from scipy.stats import mannwhitneyu, norm

from robolaser.arrays import Array

LEVEL = 0.05
"""Adjusted p below which two solvers differ significantly. In at most one of twenty benchmarks of equal solvers a pair
is called different over a whole family in one measure; the same holds for all pairs on its single problems."""
MOST_SEEDS = 100
"""More than anybody needs: what is not significant then is not a matter of seeds."""


def superiority(outcomes: Array) -> Array:
    """A12 of each pair of algorithms, the mean over problems where both have runs, outcomes (p, a, s) -> (a, a).

    How often a run of the one does better than a run of the other, ties counting half, NaN where there are none: Vargha
    & Delaney 2000; Arcuri & Briand 2011 ask for it beside every test of randomised algorithms.
    """
    one, other = outcomes[:, :, None, :, None], outcomes[:, None, :, None, :]
    won = (one < other).sum(axis=(3, 4)) + 0.5 * (one == other).sum(axis=(3, 4))
    runs = (~np.isnan(outcomes)).sum(axis=2)
    shares = np.ma.masked_invalid(
        won / np.where(runs[:, :, None] * runs[:, None] > 0, runs[:, :, None] * runs[:, None], np.nan)
    )
    return np.asarray(shares.mean(axis=0).filled(np.nan))


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
    continuity. Where there is but one problem it is Mann & Whitney's test. Symmetric, NaN on the diagonal and where no
    problem has runs of both.
    """
    there = ~np.isnan(outcomes).all(axis=(1, 2))
    if there.sum() == 1:
        single: Array = rank_sum(outcomes[there])[0]
        return single
    algorithms = outcomes.shape[1]
    p = np.full((algorithms, algorithms), np.nan)
    for i, j in combinations(range(algorithms), 2):
        both = [(x[~np.isnan(x)], y[~np.isnan(y)]) for x, y in outcomes[:, (i, j)]]
        both = [(x, y) for x, y in both if len(x) and len(y)]
        if both:
            p[i, j] = p[j, i] = _van_elteren(both)
    return p


def smallest(runs: int, problems: int) -> float:
    """P of two algorithms with so many runs each on each problem, all runs of the one better than all of the other."""
    return float(stratified(np.tile(np.arange(2.0 * runs).reshape(2, runs), (problems, 1, 1)))[0, 1])


def fewest_runs(problems: int, comparisons: int) -> int | None:
    """Runs of each on each problem with which the largest possible difference is significant after Holm's correction.

    None if `MOST_SEEDS` are too few.
    """
    enough = (n for n in range(1, MOST_SEEDS + 1) if comparisons * smallest(n, problems) < LEVEL)
    return next(enough, None)


def holm(p: Array) -> Array:
    """P after correction for all comparisons made, so that any is wrong in no more than so many. Holm 1979.

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
