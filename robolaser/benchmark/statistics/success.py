"""How many runs reached a target, and how many would."""

from functools import cache

import numpy as np
from scipy.stats import binomtest

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.intervals import CONFIDENCE, Intervals


def successes(running_times: Array) -> tuple[Ints, Ints]:
    """Runs that reached a target, and runs there are: running_times (..., s) -> two (...)."""
    return np.isfinite(running_times).sum(axis=-1), (~np.isnan(running_times)).sum(axis=-1)


def wilson(reached: Ints, runs: Ints) -> Intervals:
    """Share of the runs that reached a target, with its score interval. Wilson 1927; Brown, Cai & DasGupta 2001.

    NaN where there are no runs. Pooled over problems of different difficulty the interval is a little wider than it
    need be.
    """
    reached, runs = np.broadcast_arrays(reached, runs)
    intervals = [_interval(int(k), int(n)) for k, n in zip(reached.flat, runs.flat, strict=True)]
    value, lower, upper = np.array(intervals, np.float64).reshape(-1, 3).T.reshape(3, *runs.shape)
    return Intervals(value, lower, upper)


@cache
def _interval(reached: int, runs: int) -> tuple[float, float, float]:
    """Share, lower and upper bound of one."""
    if not runs:
        return np.nan, np.nan, np.nan
    found = binomtest(reached, runs).proportion_ci(CONFIDENCE, method="wilson")
    return reached / runs, float(found.low), float(found.high)
