"""A share that runs estimate, and the bounds of what it could be as well."""

import math
from dataclasses import dataclass
from typing import final

from scipy.stats import binomtest

CONFIDENCE = 0.95
"""Level of the interval."""


@final
@dataclass(frozen=True)
class IntervalEstimate:
    """A number and its interval; None where there are no runs."""

    value: float | None
    lower: float | None = None
    upper: float | None = None


def finite(number: float) -> float | None:
    """A number for JSON, which knows neither NaN nor infinity."""
    return float(number) if math.isfinite(number) else None


def wilson(reached: int, runs: int) -> IntervalEstimate:
    """Share of the runs that reached a target, with its score interval. Wilson 1927; Brown, Cai & DasGupta 2001.

    Pooled over problems of different difficulty the interval is a little wider than it need be.
    """
    if not runs:
        return IntervalEstimate(None)
    found = binomtest(reached, runs).proportion_ci(CONFIDENCE, method="wilson")
    return IntervalEstimate(reached / runs, float(found.low), float(found.high))
