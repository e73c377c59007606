"""How many runs reached a target, and how many would."""

import numpy as np
from statsmodels.stats.proportion import proportion_confint

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.bounded import CONFIDENCE, Bounded


def successes(prices: Array) -> tuple[Ints, Ints]:
    """Runs that reached a target, and runs there are: prices (..., s) -> two (...)."""
    return np.isfinite(prices).sum(axis=-1), (~np.isnan(prices)).sum(axis=-1)


def wilson(reached: Ints, runs: Ints) -> Bounded:
    """Share of the runs that reached a target, with its score interval. Wilson 1927; Brown, Cai & DasGupta 2001.

    Pooled over problems of different difficulty the interval is a little wider than it need be.

    Args:
        reached: Successes, (...).
        runs: All runs, (...); where there are none, all is NaN.
    """
    runs_or_nan = np.where(np.asarray(runs) > 0, runs, np.nan)
    lower, upper = proportion_confint(np.asarray(reached, float), runs_or_nan, alpha=1 - CONFIDENCE, method="wilson")
    return Bounded(reached / runs_or_nan, np.asarray(lower, float), np.asarray(upper, float))
