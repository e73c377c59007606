"""The paper's termination: the best cost has stalled."""

import math
from typing import Any, final

from pymoo.core.termination import Termination

from robolaser.errors import AlgorithmError


def several_objectives(where: str, objectives: int) -> AlgorithmError:
    """The error of a search for one objective on a problem with several."""
    return AlgorithmError(
        f"{where} minimises one objective, but the problem has {objectives}."
        " Take NSGA2 or another multi-objective algorithm; robolaser's operators work in it."
    )


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
        self.best = math.inf
        self.since = 0

    def _update(self, algorithm: Any) -> float:
        if algorithm.problem.n_obj != 1:
            raise several_objectives("Stalled", algorithm.problem.n_obj)
        costs = (float(one.F[0]) for one in algorithm.opt if one.feas)
        cost = min((cost for cost in costs if not math.isnan(cost)), default=math.inf)
        if cost < self.best or self.since == 0:
            self.best, self.since = cost, algorithm.n_iter
        return float(algorithm.n_iter - self.since >= self.generations)
