"""Terminations: a cost is reached, or the best cost has stalled."""

from typing import Any, final

import numpy as np
from pymoo.core.termination import Termination

from robolaser.algorithms.array_based import ArrayBased
from robolaser.errors import AlgorithmError


def _best_cost(algorithm: Any, where: str) -> float:
    if algorithm.problem.n_obj != 1:
        raise several_objectives(where, algorithm.problem.n_obj)
    if isinstance(algorithm, ArrayBased):
        return algorithm.best_cost()
    costs = algorithm.opt.get("F")[algorithm.opt.get("feas"), 0]
    return float(np.min(costs, initial=np.inf, where=~np.isnan(costs)))


def several_objectives(where: str, objectives: int) -> AlgorithmError:
    """A search for one objective met a problem with several."""
    return AlgorithmError(
        f"{where} minimises one objective, but the problem has {objectives}."
        " Take NSGA2 or another multi-objective algorithm; robolaser's operators work in it."
    )


@final
class CostReached(Termination):
    """Stops once a feasible individual costs no more than a target; the paper's fitness value, as J = A/F.

    Args:
        cost: The target, in the unit of the objective.

    Examples:
        >>> from robolaser.algorithms import CostReached
        >>> result = minimize(sphere, GA(), CostReached(1e-3), seed=1)
        >>> bool(result.F[0] <= 1e-3)
        True
    """

    def __init__(self, cost: float) -> None:
        super().__init__()
        self.cost = cost

    def _update(self, algorithm: Any) -> float:
        return float(_best_cost(algorithm, "CostReached") <= self.cost)


@final
class Stalled(Termination):
    """Stops once the best cost ever seen has not fallen for a number of generations.

    Args:
        generations: How many; the paper waits for 10 000.

    Raises:
        AlgorithmError: `generations` is below 1.

    Examples:
        >>> from robolaser.algorithms import Stalled
        >>> result = minimize(sphere, GA(), Stalled(10), seed=1)
        >>> bool(result.F[0] < 0.01)
        True
    """

    def __init__(self, generations: int = 10_000) -> None:
        super().__init__()
        if generations < 1:
            raise AlgorithmError(f"Stalled: generations is {generations!r}, expected a number of at least 1.")
        self.generations = generations
        self.best = np.inf
        self.since = 0

    def _update(self, algorithm: Any) -> float:
        cost = _best_cost(algorithm, "Stalled")
        if cost < self.best or self.since == 0:
            self.best, self.since = cost, algorithm.n_iter
        return float(algorithm.n_iter - self.since >= self.generations)
