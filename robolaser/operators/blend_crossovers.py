"""Crossovers that may leave the span of their parents; what leaves the bounds is moved onto them."""

from typing import Any, final

import numpy as np
from pymoo.core.crossover import Crossover
from pymoo.core.population import Population

from robolaser.arrays import Array
from robolaser.errors import AlgorithmError
from robolaser.operators import cost
from robolaser.operators.bounds import within_bounds


@final
class BlendCrossover(Crossover):
    """BLX-α: each gene of each child uniform in its parents' span, widened by α times its length on both sides.

    Eshelman and Schaffer 1993; α = 0.5 neither shrinks nor widens a population that is not selected. Draws
    random((2, n, d)).

    Args:
        alpha: α, from 0 up.
        prob: Probability that a pair is crossed at all.

    Raises:
        AlgorithmError: α is negative.

    Examples:
        >>> from robolaser.operators import BlendCrossover
        >>> result = minimize(sphere, GA(crossover=BlendCrossover(alpha=0.3)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(self, alpha: float = 0.5, prob: float = 0.85, **kwargs: Any) -> None:
        super().__init__(n_parents=2, n_offsprings=2, prob=prob, **kwargs)
        self.alpha = _from_zero_up(alpha, "alpha", "BlendCrossover")

    def _do(self, problem: Any, X: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
        lower, upper = X.astype(np.float64).min(axis=0), X.astype(np.float64).max(axis=0)
        margin = self.alpha * (upper - lower)
        draws = random_state.random(X.shape)
        return within_bounds(lower - margin + draws * (upper - lower + 2.0 * margin), problem)


@final
class ExtendedArithmeticCrossover(Crossover):
    """Children on the line through their parents, and beyond them: λ ~ U[−δ, 1 + δ], one for each pair.

    Mühlenbein and Schlierkamp-Voosen 1993, extended line recombination. With δ = 0 it is arithmetic crossover, which
    can only contract a population. Draws random((n, 1)).

    Args:
        delta: δ, from 0 up.
        prob: Probability that a pair is crossed at all.

    Raises:
        AlgorithmError: δ is negative.

    Examples:
        >>> from robolaser.operators import ExtendedArithmeticCrossover
        >>> result = minimize(sphere, GA(crossover=ExtendedArithmeticCrossover(delta=0.25)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(self, delta: float = 0.25, prob: float = 0.85, **kwargs: Any) -> None:
        super().__init__(n_parents=2, n_offsprings=2, prob=prob, **kwargs)
        self.delta = _from_zero_up(delta, "delta", "ExtendedArithmeticCrossover")

    def _do(self, problem: Any, X: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
        share = (1.0 + 2.0 * self.delta) * random_state.random((X.shape[1], 1)) - self.delta
        parents = X.astype(np.float64)
        return within_bounds(share * parents + (1.0 - share) * parents[::-1], problem)


@final
class HeuristicCrossover(Crossover):
    """Children beyond the better parent, away from the worse: x = better + r (better − worse), r ~ U[0, 1].

    Wright 1991; GENOCOP's, Michalewicz 1996. One r for each child, random((2, n, 1)). With several objectives the
    better parent is the one on the better non-dominated front.

    Args:
        prob: Probability that a pair is crossed at all.

    Raises:
        AlgorithmError: When called, if the algorithm passes genes without costs (MixedVariableGA does).

    Examples:
        >>> from robolaser.operators import HeuristicCrossover
        >>> result = minimize(sphere, GA(crossover=HeuristicCrossover()), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(self, prob: float = 0.85, **kwargs: Any) -> None:
        super().__init__(n_parents=2, n_offsprings=2, prob=prob, **kwargs)

    def do(self, problem: Any, pop: Any, parents: Any = None, *args: Any, **kwargs: Any) -> Any:
        """Cross pairs of individuals, as pymoo's `Crossover.do`; their costs are needed beside their genes."""
        pairs = [pop[mating] for mating in parents] if parents is not None else pop
        if any(one.F is None or not len(one.F) for pair in pairs for one in pair):
            raise AlgorithmError(
                "HeuristicCrossover moves away from the worse parent, but this algorithm (MixedVariableGA, for one)"
                " passes parents without their costs. Take ArithmeticCrossover or BlendCrossover instead."
            )
        J = np.array([cost.of_population(Population.create(*pair)) for pair in pairs])
        return super().do(problem, pop, parents, *args, costs=J, **kwargs)

    def _do(self, problem: Any, X: Array, *args: Any, costs: Array, random_state: Any = None, **kwargs: Any) -> Array:
        second = (costs[:, 1] < costs[:, 0])[:, None]
        mothers, fathers = X.astype(np.float64)
        better, worse = np.where(second, fathers, mothers), np.where(second, mothers, fathers)
        return within_bounds(better + random_state.random((2, X.shape[1], 1)) * (better - worse), problem)


@final
class SimpleCrossover(Crossover):
    """The children exchange all genes behind a random place. GENOCOP's, Michalewicz 1996; in a box no contraction.

    Draws integers(1, d, n), where the exchange begins.

    Args:
        prob: Probability that a pair is crossed at all.

    Examples:
        >>> from robolaser.operators import SimpleCrossover
        >>> result = minimize(sphere, GA(crossover=SimpleCrossover()), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(self, prob: float = 0.85, **kwargs: Any) -> None:
        super().__init__(n_parents=2, n_offsprings=2, prob=prob, **kwargs)

    def _do(self, problem: Any, X: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
        _, n, d = X.shape
        behind = np.arange(d) >= random_state.integers(1, max(d, 2), n)[:, None]
        return np.where(behind, X[::-1], X)


def _from_zero_up(value: float, setting: str, operator: str) -> float:
    if not value >= 0.0:
        raise AlgorithmError(f"{operator}: {setting} is {value!r}, expected a number of at least 0.")
    return value
