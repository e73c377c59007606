"""Weights on the roulette wheel from costs: the paper's, and those that do not depend on where the cost's zero lies.

Each takes costs (n,) and gives weights (n,), none negative and not all 0. A cost that is infinite or not a number has
no weight, unless no cost is finite: then all are alike.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from robolaser.arrays import Array


def inverse_cost(J: Array) -> Array:
    """Fitness A/J with A such that the best has 1. Lee et al. 2004, eq. 19.

    It depends on the cost's zero: with 1000 added to every cost all are nearly alike, and the wheel hardly selects.
    A cost of 0 leaves nothing to the others. If a cost is negative, as no sum of squares is, A/J has no meaning; then
    costs count from the best one, in units of the others' median excess m over it: F = 1/(1 + (J − J_min)/m).
    """
    best = float(J.min())
    if math.isnan(best):
        J = np.where(np.isnan(J), np.inf, J)
        best = float(J.min())
    if best == 0.0 or not math.isfinite(best):
        return np.asarray(best == J, np.float64)
    if best > 0.0:
        return best / J
    excess = J - best
    others = excess[np.isfinite(excess) & (excess > 0.0)]
    return 1.0 / (1.0 + excess / np.median(others)) if len(others) else np.asarray(best == J, np.float64)


def windowing(J: Array) -> Array:
    """J_max − J, how much better than the worst of the generation; the worst has no weight. Grefenstette 1986."""
    return _weights(J, lambda finite: finite.max() - finite)


def sigma_scaling(J: Array) -> Array:
    """max(1 + (mean − J) / 2σ, 0.1): so many offspring as standard deviations say. Tanese 1989, in Mitchell 1996."""
    return _weights(J, lambda finite: np.maximum(1.0 + (finite.mean() - finite) / (2.0 * (finite.std() or 1.0)), 0.1))


def linear_ranking(J: Array) -> Array:
    """From 2 for the best to 0 for the worst, by rank alone, equal costs alike. Baker 1985, selection pressure 2."""
    return _weights(J, _from_ranks)


SCALINGS: Mapping[str, Callable[[Array], Array]] = {
    "inverse": inverse_cost,
    "windowing": windowing,
    "sigma": sigma_scaling,
    "ranking": linear_ranking,
}
"""By name."""


def _from_ranks(J: Array) -> Array:
    order = np.sort(J)
    better = (order.searchsorted(J, "left") + order.searchsorted(J, "right") - 1) / 2.0
    return 2.0 * (1.0 - better / max(len(J) - 1, 1))


def _weights(J: Array, scaled: Callable[[Array], Array]) -> Array:
    finite = np.isfinite(J)
    if not finite.any():
        return np.ones(len(J))
    weights = np.zeros(len(J))
    weights[finite] = scaled(J[finite])
    return weights if weights.any() else np.asarray(finite, np.float64)
