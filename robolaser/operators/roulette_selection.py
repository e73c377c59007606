"""Roulette-wheel selection: parents are drawn in proportion to their fitness, which follows from their costs."""

import math
from typing import Any, final

import numpy as np
from pymoo.core.selection import Selection

from robolaser.arrays import Array, Ints
from robolaser.operators import cost


def inverse_cost(J: Array) -> Array:
    """Fitness A/J with A such that the best has 1. Lee et al. 2004, eq. 19.

    It depends on the cost's zero: with 1000 added to every cost all are nearly equal, and the wheel hardly selects.
    A cost of 0 takes all. If a cost is negative, as no sum of squares is, A/J has no meaning; then costs count from the
    best one, in units of the others' median excess m over it: F = 1/(1 + (J − J_min)/m).
    """
    best = float(J.min())
    if best == 0.0 or not math.isfinite(best):
        return np.asarray(best == J, np.float64)
    if best > 0.0:
        return best / J
    excess = J / 4 - best / 4  # neither it nor the sum of two overflows
    others = excess[np.isfinite(excess) & (excess > 0.0)]
    with np.errstate(over="ignore"):
        return 1.0 / (1.0 + excess / np.median(others)) if len(others) else np.asarray(best == J, np.float64)


def roulette_wheel(weights: Array, at: Array) -> Ints:
    """Slots of the wheel, as wide as their weights (n,), at stops in [0, 1) (...) -> (...). Eq. 20."""
    wheel = weights.cumsum()
    return np.asarray(wheel.searchsorted(at * wheel[-1], side="right"))


@final
class RouletteSelection(Selection):
    """Roulette-wheel selection for pymoo, with replacement.

    Draws random((n_select, n_parents)) from `random_state`. With several objectives the cost of an individual
    is the number of its non-dominated front; the cost of an infeasible one is its violation above the worst
    feasible cost.

    Examples:
        >>> from robolaser.operators import RouletteSelection
        >>> result = minimize(sphere, GA(selection=RouletteSelection()), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def _do(self, problem: Any, pop: Any, n_select: int, n_parents: int, *, random_state: Any, **kwargs: Any) -> Ints:
        return roulette_wheel(inverse_cost(cost.of_population(pop)), random_state.random((n_select, n_parents)))
