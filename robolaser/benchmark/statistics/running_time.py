"""The expected running time to a target, ERT, its ratios between algorithms, and targets reached by when.

What an algorithm pays on average until it reaches a target if it is begun anew, with another seed, as often as it
fails: all that all runs paid up to the target or their end, over the number of those that reached it. Auger & Hansen
2005; Hansen, Auger, Ros, Mersmann, Tusar & Brockhoff 2021 (COCO), section 5.

Intervals are of the expanded percentile bootstrap over seeds: Efron 1979; Hesterberg 2015, section 5.3, since plain
percentiles of few runs are too narrow.
"""

from itertools import permutations

import numpy as np
from scipy.stats import norm, t

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.intervals import CONFIDENCE, Intervals

SAMPLES = 2000
"""Bootstrap samples: expanded percentiles of five runs lie a thousandth from the ends."""
BUDGETS = 200  # of a curve
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
    """ERT to one target in bootstrap samples: times and totals (p, a, s), draws (p, b, s) -> (p, a, b)."""
    weights = np.swapaxes(drawn, 1, 2).astype(float)  # (p, s, b)
    paid = _paid(running_times[..., None], totals)[..., 0]
    return _over(paid @ weights, np.isfinite(running_times).astype(float) @ weights)


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
    solved, count = np.isfinite(value), value.shape[1]
    ratios = np.full((3, count, count), np.nan)
    for one, other in permutations(range(count), 2):  # pair by pair: all at once would take gigabytes
        both = solved[:, one] & solved[:, other]
        if both.any():
            fewer = np.minimum(runs[both, one], runs[both, other])
            with np.errstate(invalid="ignore", divide="ignore"):
                mean = np.exp(np.log(value[both, other] / value[both, one]).mean())
                drawn = np.exp(np.log(samples[both, other] / samples[both, one]).mean(axis=0))
            found = _bounds(mean, drawn, fewer.min(), (fewer - 1).sum())
            ratios[:, one, other] = found.value, found.lower, found.upper
    return Intervals(*ratios)


def budgets(running_times: Array, totals: Array) -> Array:
    """Some budgets (b,) from the first target that any run reached to the end of the longest, evenly in logarithms.

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
