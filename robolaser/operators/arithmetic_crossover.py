"""Arithmetic crossover: two children on the straight line between their parents."""

from typing import Any, final

import numpy as np
from pymoo.core.crossover import Crossover

from robolaser.arrays import Array
from robolaser.operators.bounds import check_share


def arithmetic(parents: Array, share: Array) -> Array:
    """Blend pairs of parents, (2, n, d) and (n, 1) -> their children, (2, n, d). Lee et al. 2004, eq. 21.

    The children are clipped to the span of their parents, which the sum leaves by a rounding error: a
    variable in which both parents agree does not change.
    """
    mothers, fathers = parents
    children: Array = share * parents
    children += (1.0 - share) * parents[::-1]
    np.maximum(children, np.minimum(mothers, fathers), out=children)
    np.minimum(children, np.maximum(mothers, fathers), out=children)
    return children


@final
class ArithmeticCrossover(Crossover):
    """Arithmetic crossover for pymoo: one λ ~ U[0, 1] for each pair of parents.

    Draws from `random_state` the coins of pymoo's `Crossover.do`, random(n_matings), then, if any pair is to
    be crossed, λ for all, random((n_matings, 1)).

    Args:
        prob: Probability that a pair is crossed at all; the others are copied.

    Raises:
        AlgorithmError: It is no probability.

    Examples:
        >>> from robolaser.operators import ArithmeticCrossover
        >>> result = minimize(sphere, GA(crossover=ArithmeticCrossover(prob=0.85)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(self, prob: float = 0.85, **kwargs: Any) -> None:
        super().__init__(n_parents=2, n_offsprings=2, prob=prob, **kwargs)
        check_share(self.name, "prob", prob)

    def _do(self, problem: Any, X: Array, *args: Any, random_state: Any, **kwargs: Any) -> Array:
        return arithmetic(X.astype(np.float64), random_state.random((X.shape[1], 1)))
