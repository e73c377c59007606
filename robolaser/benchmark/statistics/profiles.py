"""Shares of problems that are solved with so much, whatever makes some problems dearer than others taken out."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.benchmark.statistics.ecdf import shares


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
