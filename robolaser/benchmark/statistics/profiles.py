"""What runs reached by when: shares of targets within a budget, and costs after so many evaluations.

Budgets of the ECDF are plain evaluations or seconds, not per dimension: these problems are no one function scaled to
more variables, and who calibrates pays for evaluations. Hansen, Auger, Brockhoff & Tusar 2022, "Anytime performance
assessment in blackbox optimization benchmarking".
"""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.benchmark.evaluator import ConvergenceTrace
from robolaser.benchmark.statistics.intervals import quantiles

BAND = np.array([0.1, 0.5, 0.9])
"""Quantiles over seeds: the median, and what one run in ten does better or worse than."""


def budgets(running_times: Array, totals: Array, points: int = 200) -> Array:
    """Budgets (points,) from the first target that any run reached to the end of the longest, evenly in logarithms.

    Empty if no run reached any.
    """
    reached = running_times[np.isfinite(running_times) & (running_times > 0)]
    if not len(reached):
        return np.empty(0)
    return np.geomspace(reached.min(), max(np.nanmax(totals), reached.max()), points)


def shares(running_times: Array, budgets: Array) -> Array:
    """Shares of (problem, seed, target) reached within budgets, (p, a, s, t) and (g,) -> (a, g); NaN without runs."""
    found = np.full((running_times.shape[1], len(budgets)), np.nan)
    for a, row in enumerate(found):
        there = np.sort(running_times[:, a][~np.isnan(running_times[:, a])])
        if len(there):
            row[:] = np.searchsorted(there, budgets, side="right") / len(there)
    return found


def areas(running_times: Array, first: float, last: float) -> Array:
    """Area under the ECDF on a logarithmic axis of budgets, (p, a, s, t) -> (a,), 0 to 1; NaN without runs.

    That is, the mean over (problem, seed, target) of the share of the axis that was left when it was reached. Lopez-
    Ibanez, Vermetten, Dreo & Doerr 2024, "Using the empirical attainment function for analyzing single-objective black-
    box optimization algorithms".
    """
    left = np.log(last / np.clip(running_times, first, last)) / np.log(last / first)
    there = ~np.isnan(running_times)
    total, count = np.where(there, left, 0.0).sum(axis=(0, 2, 3)), there.sum(axis=(0, 2, 3))
    area: Array = total / np.where(count > 0, count, np.nan)
    return area


def data_profile(running_times: Array, dimensions: Ints, budgets: Array) -> Array:
    """Shares of (problem, run, target) solved within so many simplex gradients of d + 1 evaluations each.

    Running times in evaluations (p, a, s, t), dimensions (p,), budgets (g,) -> (a, g). Moré & Wild 2009, "Benchmarking
    derivative-free optimization algorithms".
    """
    return shares(running_times / (np.asarray(dimensions)[:, None, None, None] + 1.0), budgets)


def performance_ratios(expected: Array) -> Array:
    """How many times as long as the fastest on that problem and target each needs, (p, a, t) -> (p, a, t).

    Infinite where only others reached the target, NaN where none did or there are no runs.
    """
    fastest = np.where(np.isnan(expected), np.inf, expected).min(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        ratios: Array = expected / np.where(np.isfinite(fastest), fastest, np.nan)
    return ratios


def performance_profile(expected: Array, factors: Array) -> Array:
    """Shares of (problem, target) on which each needs at most so many times as long as the fastest.

    Expected times (p, a, t) and factors (g,) -> (a, g). At factor 1 the share on which it is the fastest, far right the
    share that it solves at all of what anybody solves. Dolan & Moré 2002, "Benchmarking optimization software with
    performance profiles". Gould & Scott 2016: with more than two algorithms, only who is best can be read from it, not
    who is second.
    """
    return shares(performance_ratios(expected)[:, :, None], factors)


def after_evaluations(traces: Sequence[ConvergenceTrace], at: Array) -> Array:
    """Lowest cost of each run after so many evaluations (g,) -> (s, g)."""
    return np.array([trace.best_after(at) for trace in traces]).reshape(-1, len(at))


def bands(costs: Array, best: float, scale: float, levels: Array = BAND) -> Array:
    """Quantiles over runs of how far costs (s, g) are above the best, in units of a scale, (q, g); NaN without runs."""
    excess = (costs - best) / scale
    return quantiles(excess.T, levels).T if len(costs) else np.full((len(levels), costs.shape[1]), np.nan)
