"""Selection by a wheel: parents are drawn in proportion to their fitness."""

from abc import ABC, abstractmethod
from typing import Any, Literal, final

import numpy as np
from pymoo.core.selection import Selection

from robolaser.arrays import Array, Ints
from robolaser.errors import AlgorithmError
from robolaser.operators import cost
from robolaser.operators.scaling import SCALINGS

Scaling = Literal["inverse", "windowing", "sigma", "ranking"]


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
        scaling: How costs become weights, see `robolaser.operators.scaling`: "inverse" is the paper's A/J, which
            depends on where the cost's zero lies; "windowing", "sigma" and "ranking" do not.

    Raises:
        AlgorithmError: There is no such scaling.

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
    """All parents by one turn of a wheel with equally spaced marks. Baker 1987.

    Each individual is chosen as often as its weight says, rounded up or down. What costs mean is as in
    `RouletteSelection`. Draws from `random_state` where the wheel stops, random(), then the order of the chosen,
    permutation.

    Args:
        scaling: How costs become weights, as in `RouletteSelection`.

    Raises:
        AlgorithmError: There is no such scaling.

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
