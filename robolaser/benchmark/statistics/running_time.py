"""The expected running time to a target, ERT, and how many times longer one algorithm takes than another.

What an algorithm pays on average until it reaches a target if it is begun anew, with another seed, as often as it
fails: all that all runs paid up to the target or their end, over the number of those that reached it. Auger & Hansen
2005; Hansen, Auger, Ros, Mersmann, Tusar & Brockhoff 2021 (COCO), section 5.

Intervals are of the expanded percentile bootstrap over seeds: Efron 1979; Hesterberg 2015, section 5.3, since plain
percentiles of few runs are too narrow.
"""

import numpy as np
from scipy.stats import norm, t

from robolaser.arrays import Array, Bools, Ints
from robolaser.benchmark.statistics.intervals import CONFIDENCE, Intervals

SAMPLES = 2000
"""Bootstrap samples: expanded percentiles of five runs lie a thousandth from the ends."""
FEWEST, FEWEST_RUNS = 4, 3
"""Degrees of freedom, five runs on one problem or three on each of two, and runs on a problem, below which there is no
interval: few runs, drawn again and again, give the same handful of numbers. With these, intervals that should hold the
truth 95 times in a hundred do so at least 92 times."""


def expected(running_times: Array, totals: Array) -> Array:
    """ERT of each target, running times (..., s, t) and totals of the whole runs (..., s) -> (..., t).

    Infinite where no run reached the target, NaN where there are no runs.
    """
    return _over(_paid(running_times, totals).sum(axis=-2), np.isfinite(running_times).sum(axis=-2))


def draws(problems: int, seeds: int, rng: np.random.Generator, samples: int = SAMPLES) -> Ints:
    """How often each seed is drawn in a bootstrap sample of as many seeds, on each problem anew, (p, b, s).

    The same for all algorithms: what may be common to runs with one seed stays so.
    """
    drawn: Ints = rng.multinomial(seeds, np.full(seeds, 1.0 / seeds), size=(problems, samples))
    return drawn


def resampled(running_times: Array, totals: Array, drawn: Ints) -> Array:
    """ERT in bootstrap samples: running times (p, a, s, t), totals (p, a, s), draws (p, b, s) -> (p, a, t, b)."""
    p, a, s, targets = running_times.shape
    weights = np.swapaxes(drawn, 1, 2).astype(float)  # (p, s, b)

    def total(of_runs: Array) -> Array:
        rows = np.moveaxis(of_runs, 2, 3).reshape(p, a * targets, s)
        totals: Array = (rows @ weights).reshape(p, a, targets, weights.shape[2])
        return totals

    return _over(total(_paid(running_times, totals)), total(np.isfinite(running_times).astype(float)))


def bounds(value: Array, samples: Array, runs: Ints) -> Intervals:
    """Intervals of numbers (...) that were estimated from so many runs (...), and anew in bootstrap samples (..., b).

    A sample without an answer, NaN, could be anything.
    """
    return _bounds(value, samples, runs, runs - 1)


def mean_ratios(samples: Array, value: Array, runs: Ints) -> Intervals:
    """How many times longer the other takes than the one: geometric mean over problems on which both succeeded.

    ERT to one target in bootstrap samples (p, a, b), of all runs (p, a), and runs (p, a) -> (a, a), the second
    algorithm's over the first's; NaN where there is no such problem.
    """
    solved = np.isfinite(value)
    both = solved[:, :, None] & solved[:, None, :]
    count = both.sum(axis=0)
    fewer = np.minimum(runs[:, :, None], runs[:, None, :])
    freedoms = np.where(both, fewer - 1, 0).sum(axis=0)
    fewest = np.where(both, fewer, np.iinfo(np.int64).max).min(axis=0, initial=np.iinfo(np.int64).max)

    def mean(other: Array, one: Array, counted: Bools) -> Array:
        with np.errstate(invalid="ignore", divide="ignore"):
            logs = np.where(counted, np.log(other / one), 0.0).sum(axis=0)
            averaged: Array = np.exp(logs / np.where(counted.any(axis=0), counted.sum(axis=0), np.nan))
        return averaged

    return _bounds(
        mean(value[:, None, :], value[:, :, None], both),
        mean(samples[:, None, :, :], samples[:, :, None, :], both[..., None]),
        np.where(count > 0, fewest, 0),
        freedoms,
    )


def _paid(running_times: Array, totals: Array) -> Array:
    """Up to the target, or the end; nothing where there is no run."""
    return np.nan_to_num(np.where(np.isfinite(running_times), running_times, totals[..., None]), nan=0.0)


def _over(paid: Array, reached: Array | Ints) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        expected: Array = np.where((reached == 0) & (paid > 0), np.inf, paid / reached)
    return expected


def _bounds(value: Array, samples: Array, runs: Ints, freedoms: Ints) -> Intervals:
    enough = (freedoms >= FEWEST) & (runs >= FEWEST_RUNS) & ~np.isnan(value)
    n, df = np.where(enough, runs, 2), np.where(enough, freedoms, 1)
    level = norm.cdf(np.sqrt(n / (n - 1)) * t.ppf((1 - CONFIDENCE) / 2, df))
    count = samples.shape[-1]
    at = np.clip(np.floor(level * count).astype(int), 0, count - 1)[..., None]
    unknown = np.isnan(samples)

    def picked(filled: Array, at: Ints) -> Array:
        picked: Array = np.take_along_axis(np.sort(filled, axis=-1), at, axis=-1)[..., 0]
        return np.where(enough, picked, np.nan)

    return Intervals(
        value,
        picked(np.where(unknown, 0.0, samples), at),
        picked(np.where(unknown, np.inf, samples), count - 1 - at),
    )
