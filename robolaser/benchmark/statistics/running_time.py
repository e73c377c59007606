"""The expected running time to a target, ERT, its ratios between algorithms, and reached targets over time.

ERT is the mean cost until an algorithm reaches a target if it is restarted with another seed as often as it fails: the
sum over all runs up to the target or their end, divided by the number of those that reached it. Auger & Hansen
2005; Hansen, Auger, Ros, Mersmann, Tusar & Brockhoff 2021 (COCO), section 5.

Intervals are those of the expanded percentile bootstrap over seeds: Efron 1979; Hesterberg 2015, section 5.3, since
plain percentiles of few runs are too narrow.
"""

from itertools import permutations

import numpy as np
from scipy.stats import norm, t

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.intervals import CONFIDENCE, Intervals

SAMPLES = 2000  # bootstrap samples: expanded percentiles of five runs are a thousandth from the ends
BUDGETS = 200  # of a curve
FEWEST, FEWEST_RUNS = 4, 3
"""Least degrees of freedom (five runs on one problem, or three on each of two) and runs on a problem for an interval:
resamples of fewer runs have too few different values. With these, 95 % intervals hold the truth at least 92 times in
a hundred."""


def expected(running_times: Array, totals: Array) -> Array:
    """ERT to a target, times and totals of the whole runs (p, a, s) -> (p, a, 1 + b): of all runs, then of samples b.

    A sample has as many seeds, drawn for each problem, and the same for all algorithms, which preserves correlations of
    runs with one seed. Infinite where no run reached the target, NaN where there are no runs.
    """
    problems, _, seeds = running_times.shape
    drawn = np.random.default_rng(1).multinomial(seeds, np.full(seeds, 1.0 / seeds), size=(problems, SAMPLES))
    weights = np.concatenate([np.ones((problems, seeds, 1)), np.swapaxes(drawn, 1, 2)], axis=2)
    reached = np.isfinite(running_times)
    paid = np.nan_to_num(np.where(reached, running_times, totals), nan=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(paid @ weights / (reached @ weights))


def mean_ratios(expected: Array, runs: Ints) -> Intervals:
    """Ratios of running times: geometric mean over problems on which both algorithms succeeded.

    ERT of all runs and of samples (p, a, 1 + b), and runs (p, a) -> (a, a), the second algorithm's over the first's;
    NaN where there is no such problem.
    """
    solved, count = np.isfinite(expected[..., 0]), expected.shape[1]
    ratios = np.full((3, count, count), np.nan)
    for one, other in permutations(range(count), 2):  # pair by pair: all at once would take gigabytes
        both = solved[:, one] & solved[:, other]
        if both.any():
            fewer = np.minimum(runs[both, one], runs[both, other])
            with np.errstate(invalid="ignore", divide="ignore"):
                mean = np.exp(np.log(expected[both, other] / expected[both, one]).mean(axis=0))
            found = bounded(mean, fewer.min(), (fewer - 1).sum())
            ratios[:, one, other] = found.value, found.lower, found.upper
    return Intervals(*ratios)


def budgets(running_times: Array, totals: Array) -> Array:
    """Budgets (b,) from the first target that any run reached to the end of the longest, evenly in logarithms.

    Empty if no run reached any.
    """
    reached = running_times[np.isfinite(running_times) & (running_times > 0)]
    if not len(reached):
        return np.empty(0)
    return np.geomspace(reached.min(), max(np.nanmax(totals), reached.max()), BUDGETS)


def shares(running_times: Array, budgets: Array) -> Array:
    """Shares of (problem, seed, target) reached within budgets, (p, a, s, t) and (g,) -> (a, g); NaN without runs.

    Hansen, Auger, Brockhoff & Tusar 2022, "Anytime performance assessment in blackbox optimization benchmarking".
    """
    found = np.full((running_times.shape[1], len(budgets)), np.nan)
    for a, row in enumerate(found):
        there = np.sort(running_times[:, a][~np.isnan(running_times[:, a])])
        if len(there):
            row[:] = np.searchsorted(there, budgets, side="right") / len(there)
    return found


def bounded(found: Array, runs: Ints, freedoms: Ints) -> Intervals:
    """Numbers of all runs and of samples (..., 1 + b), of so many runs (...), with intervals.

    A sample without a value could have any: it is zero in the lower bound, infinite in the upper.
    """
    value, samples = found[..., 0], found[..., 1:]
    enough = (freedoms >= FEWEST) & (runs >= FEWEST_RUNS) & ~np.isnan(value)
    n, df = np.where(enough, runs, 2), np.where(enough, freedoms, 1)
    level = norm.cdf(np.sqrt(n / (n - 1)) * t.ppf((1 - CONFIDENCE) / 2, df))
    at = np.floor(level * SAMPLES).astype(int)[..., None]

    def picked(unknown: float, at: Ints) -> Array:
        filled = np.sort(np.where(np.isnan(samples), unknown, samples), axis=-1)
        return np.where(enough, np.take_along_axis(filled, at, axis=-1)[..., 0], np.nan)

    return Intervals(value, picked(0.0, at), picked(np.inf, SAMPLES - 1 - at))
