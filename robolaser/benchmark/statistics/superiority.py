"""How often a run of one algorithm does better than a run of another: the effect size A12.

Vargha & Delaney 2000; Arcuri & Briand 2011 ask for it beside every test of randomised algorithms.
"""

import numpy as np
from scipy.stats import norm

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.intervals import CONFIDENCE, Intervals


def wins(outcomes: Array) -> Array:
    """Pairs of runs that the first algorithm wins, ties counting half, (p, a, s) -> (p, a, a): Mann & Whitney's U."""
    one, other = outcomes[:, :, None, :, None], outcomes[:, None, :, None, :]
    won: Array = (one < other).sum(axis=(3, 4)) + 0.5 * (one == other).sum(axis=(3, 4))
    return won


def superiority(outcomes: Array) -> Intervals:
    """A12 of each pair of algorithms on each problem, with its score interval, outcomes (p, a, s) -> (p, a, a).

    The interval is Newcombe's fifth (2006): unlike a bootstrap's it does not shrink to a point where one algorithm wins
    always. NaN where either has no runs.
    """
    runs = (~np.isnan(outcomes)).sum(axis=2)
    n, m = runs[:, :, None], runs[:, None, :]
    value = wins(outcomes) / np.where(n * m > 0, n * m, np.nan)
    return Intervals(value, _bound(value, n, m, end=0.0), _bound(value, n, m, end=1.0))


def mean_superiority(of_problems: Intervals) -> Intervals:
    """Mean of A12 over the problems on which both have runs, (p, a, a) -> (a, a).

    Its interval is made of the problems' intervals: Zou & Donner 2008 (MOVER).
    """
    there = ~np.isnan(of_problems.value)
    count = np.where(there.any(axis=0), there.sum(axis=0), np.nan)

    def mean(values: Array) -> Array:
        averaged: Array = np.where(there, values, 0.0).sum(axis=0) / count
        return averaged

    def width(bound: Array) -> Array:
        across: Array = np.sqrt(np.where(there, (bound - of_problems.value) ** 2, 0.0).sum(axis=0)) / count
        return across

    value = mean(of_problems.value)
    return Intervals(
        value,
        np.maximum(value - width(of_problems.lower), 0.0),
        np.minimum(value + width(of_problems.upper), 1.0),
    )


def _bound(value: Array, n: Ints, m: Ints, *, end: float) -> Array:
    """Where between the estimate and an end of the scale it would be `CONFIDENCE` that the estimate is no farther."""
    z = norm.ppf(0.5 + CONFIDENCE / 2)
    others, pairs = (n + m) / 2 - 1, np.where(n * m > 0, n * m, 1)
    outside, inside = np.full_like(value, end), value
    for _ in range(50):  # halvings: to the last digit
        middle = (outside + inside) / 2
        spread = 1 + others * ((1 - middle) / (2 - middle) + middle / (1 + middle))
        far = (value - middle) ** 2 > z**2 * middle * (1 - middle) * spread / pairs
        outside, inside = np.where(far, middle, outside), np.where(far, inside, middle)
    return np.where(np.isnan(value), np.nan, inside)
