"""Estimates from runs, with intervals."""

import math
from dataclasses import dataclass
from typing import final

from scipy.stats import binomtest

from robolaser.arrays import Array

CONFIDENCE = 0.95  # level of every interval


@final
@dataclass(frozen=True)
class IntervalEstimate:
    """An estimate and its interval; None where the runs give none, or leave an end open."""

    value: float | None
    lower: float | None = None
    upper: float | None = None


@final
@dataclass(frozen=True, eq=False)
class Intervals:
    """Estimates, and the intervals that hold the truth with `CONFIDENCE`; all of one shape."""

    value: Array  # NaN where there is none, infinite where no run reached a target
    lower: Array  # NaN where there are too few runs
    upper: Array  # NaN where there are too few runs, infinite where they leave it open

    def at(self, *index: int) -> IntervalEstimate:
        """One of the estimates."""
        return IntervalEstimate(finite(self.value[index]), finite(self.lower[index]), finite(self.upper[index]))


def finite(number: float) -> float | None:
    """A number for JSON, which has neither NaN nor infinity."""
    return float(number) if math.isfinite(number) else None


def wilson(reached: int, runs: int) -> IntervalEstimate:
    """Share of the runs that reached a target, with its score interval. Wilson 1927; Brown, Cai & DasGupta 2001.

    Pooled over problems of different difficulty the interval is a little too wide.
    """
    if not runs:
        return IntervalEstimate(None)
    found = binomtest(reached, runs).proportion_ci(CONFIDENCE, method="wilson")
    return IntervalEstimate(reached / runs, float(found.low), float(found.high))
