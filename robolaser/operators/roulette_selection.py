"""Selection by a wheel: parents are drawn in proportion to their fitness, which follows from their costs."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, Literal, final

import numpy as np
from pymoo.core.selection import Selection

from robolaser.arrays import Array, Ints
from robolaser.errors import AlgorithmError
from robolaser.operators import cost

Scaling = Literal["inverse", "windowing", "sigma", "ranking"]


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
"""By name: each gives costs (n,) their weights (n,) on the wheel, none negative and not all 0.

A cost that is infinite or not a number has no weight, unless no cost is finite: then all are alike.
"""


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


def roulette_wheel(weights: Array, at: Array) -> Ints:
    """Slots, as wide as their weights (n,), of the wheel where it stops, at [0, 1) (...) -> (...). Eq. 20."""
    wheel = weights.cumsum()
    slots: Ints = wheel.searchsorted(at * wheel[-1], side="right")
    return slots


class _Wheel(Selection, ABC):
    """Parents are where a wheel with a slot for each individual stops."""

    def __init__(self, scaling: Scaling = "inverse", **kwargs: Any) -> None:
        super().__init__(**kwargs)
        if scaling not in SCALINGS:
            raise AlgorithmError(
                f"{type(self).__name__}: scaling is {scaling!r}, expected one of {', '.join(SCALINGS)}."
            )
        self.scaling = scaling

    def _do(
        self, problem: Any, pop: Any, n_select: int, n_parents: int = 1, *, random_state: Any = None, **kwargs: Any
    ) -> Ints:
        weights = SCALINGS[self.scaling](cost.of_population(pop))
        return roulette_wheel(weights, self._stops((n_select, n_parents), random_state))

    @abstractmethod
    def _stops(self, shape: tuple[int, int], random_state: Any) -> Array:
        """Where the wheel stops for each parent, at [0, 1)."""


@final
class RouletteSelection(_Wheel):
    """Roulette-wheel selection for pymoo, with replacement.

    Draws random((n_select, n_parents)) from `random_state`. With several objectives the cost of an individual
    is the number of its non-dominated front; one that violates constraints costs its violation more than the
    worst that keeps them.

    Args:
        scaling: How costs become weights, see `SCALINGS`: "inverse" is the paper's A/J, which
            depends on the zero of the cost; "windowing", "sigma" and "ranking" do not.

    Raises:
        AlgorithmError: The scaling is unknown.

    Examples:
        >>> from robolaser.operators import RouletteSelection
        >>> result = minimize(sphere, GA(selection=RouletteSelection()), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def _stops(self, shape: tuple[int, int], random_state: Any) -> Array:
        stops: Array = random_state.random(shape)
        return stops


@final
class StochasticUniversalSampling(_Wheel):
    """Select all parents by one turn of a wheel with equally spaced marks. Baker 1987.

    Each individual is chosen as often as its weight says, rounded up or down. Costs are as in
    `RouletteSelection`. Draws from `random_state` where the wheel stops, random(), then the order of the chosen,
    permutation.

    Args:
        scaling: How costs become weights, as in `RouletteSelection`.

    Raises:
        AlgorithmError: The scaling is unknown.

    Examples:
        >>> from robolaser.operators import StochasticUniversalSampling
        >>> result = minimize(sphere, GA(selection=StochasticUniversalSampling()), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def _stops(self, shape: tuple[int, int], random_state: Any) -> Array:
        n = shape[0] * shape[1]
        marks: Array = (random_state.random() + np.arange(n)) / n
        order: Ints = random_state.permutation(n)
        return marks[order].reshape(shape)
