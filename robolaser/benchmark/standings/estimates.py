"""Measured numbers as plain ones."""

import math

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.benchmark.problem import INFEASIBLE
from robolaser.benchmark.standings.table import FinalCosts, IntervalEstimate
from robolaser.benchmark.statistics.intervals import Intervals
from robolaser.benchmark.statistics.quantiles import quantiles
from robolaser.benchmark.statistics.success import wilson

UNKNOWN = IntervalEstimate(None, None, None)


def plain(number: float) -> float | None:
    """None for NaN and infinity."""
    return float(number) if math.isfinite(number) else None


def estimate(bounded: Intervals, at: tuple[int, ...]) -> IntervalEstimate:
    """One of many."""
    return IntervalEstimate(plain(bounded.value[at]), plain(bounded.lower[at]), plain(bounded.upper[at]))


def success(reached: Ints | int, runs: Ints | int) -> IntervalEstimate:
    """Share of runs that reached a target."""
    return estimate(wilson(np.atleast_1d(reached), np.atleast_1d(runs)), (0,))


def quality(final: Array) -> FinalCosts | None:
    """What runs (s,) ended with."""
    if np.isnan(final).all():
        return None
    feasible = np.where(final >= INFEASIBLE, np.inf, final)
    return FinalCosts(*(plain(value) for value in quantiles(feasible, np.array([0.0, 0.25, 0.5, 0.75, 1.0]))))


def violation(final: Array) -> float | None:
    """Median of the lowest violations of runs (s,) without a feasible candidate; None if there are none."""
    infeasible = final[(final >= INFEASIBLE) & np.isfinite(final)]
    return float(np.median(infeasible)) / INFEASIBLE - 1.0 if len(infeasible) else None
