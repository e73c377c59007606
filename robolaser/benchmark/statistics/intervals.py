"""Numbers that runs estimate: shares and quantiles of runs, and the bounds of what they could be as well."""

import math
from dataclasses import dataclass
from functools import cache
from typing import final

import numpy as np
from scipy.stats import binomtest

from robolaser.arrays import Array, Ints

CONFIDENCE = 0.95
"""Level of every interval."""


@final
@dataclass(frozen=True)
class IntervalEstimate:
    """A number and its interval; None where the runs give none, or leave an end open."""

    value: float | None
    lower: float | None = None
    upper: float | None = None


@final
@dataclass(frozen=True, eq=False)
class Intervals:
    """Estimates, and the intervals that hold the truth with `CONFIDENCE`; all of one shape."""

    value: Array  # NaN where there is none, infinite where no run reached a target
    lower: Array  # NaN where there are too few runs to say
    upper: Array  # NaN where there are too few runs to say, infinite where they leave it open

    def at(self, *index: int) -> IntervalEstimate:
        """One of them."""
        return IntervalEstimate(finite(self.value[index]), finite(self.lower[index]), finite(self.upper[index]))


def finite(number: float) -> float | None:
    """A number for JSON, which knows neither NaN nor infinity."""
    return float(number) if math.isfinite(number) else None


def quantiles(values: Array, levels: Array) -> Array:
    """Values at or below which lie so many of them, (..., n) and levels (q,) -> (..., q): always one that was seen.

    So infinite ones (runs that found nothing) do no harm; NaN is absent. Hyndman & Fan 1996, definition 1.
    """
    there = (~np.isnan(values)).sum(axis=-1, keepdims=True)
    at = np.clip(np.ceil(np.round(levels * there, 9)).astype(int) - 1, 0, np.maximum(there - 1, 0))
    picked: Array = np.take_along_axis(np.sort(values, axis=-1), at, axis=-1)  # NaN is sorted last
    return picked


def successes(running_times: Array) -> tuple[Ints, Ints]:
    """Runs that reached a target, and runs there are: running_times (..., s) -> two (...)."""
    return np.isfinite(running_times).sum(axis=-1), (~np.isnan(running_times)).sum(axis=-1)


def wilson(reached: Ints, runs: Ints) -> Intervals:
    """Share of the runs that reached a target, with its score interval. Wilson 1927; Brown, Cai & DasGupta 2001.

    NaN where there are no runs. Pooled over problems of different difficulty the interval is a little wider than it
    need be.
    """
    reached, runs = np.broadcast_arrays(reached, runs)
    intervals = [_wilson(int(k), int(n)) for k, n in zip(reached.flat, runs.flat, strict=True)]
    return Intervals(*np.array(intervals, np.float64).reshape(-1, 3).T.reshape(3, *runs.shape))


@cache
def _wilson(reached: int, runs: int) -> tuple[float, float, float]:
    if not runs:
        return np.nan, np.nan, np.nan
    found = binomtest(reached, runs).proportion_ci(CONFIDENCE, method="wilson")
    return reached / runs, float(found.low), float(found.high)
