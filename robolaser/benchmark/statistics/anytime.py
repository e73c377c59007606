"""How good the better and the worse of an algorithm's runs are after so many evaluations."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.convergence import ConvergenceTrace
from robolaser.benchmark.statistics.quantiles import quantiles

BAND = np.array([0.1, 0.5, 0.9])
"""Quantiles over seeds: the median, and what one run in ten does better or worse than."""


def bands(costs: Array, best: float, scale: float, levels: Array = BAND) -> Array:
    """Quantiles over runs of how far costs (s, g) are above the best, in units of a scale, (q, g); NaN without runs."""
    excess = (costs - best) / scale
    return quantiles(excess.T, levels).T if len(costs) else np.full((len(levels), costs.shape[1]), np.nan)


def after_evaluations(traces: Sequence[ConvergenceTrace], at: Array) -> Array:
    """Lowest cost of each run after so many evaluations (g,) -> (s, g)."""
    return np.array([trace.best_after(at) for trace in traces]).reshape(-1, len(at))
