"""Elitist replacement: the offspring replace all parents but the best."""

from typing import Any, final

import numpy as np
from pymoo.core.survival import Survival

from robolaser.arrays import Array, Ints
from robolaser.errors import AlgorithmError
from robolaser.operators import cost


def survivors(parents: Array, offspring: Array, n_elites: int, n_survive: int) -> Ints:
    """Who lives on, by the costs (p,) of parents and (o,) of offspring -> (n,) indices into both, joined.

    The best parents, first the best, then the offspring in their order. If these are too many the worst
    offspring are left out, if too few more parents stay. Of equals the earlier stays.
    """
    n_parents = max(min(n_elites, n_survive), n_survive - len(offspring))
    elites = parents.argsort(kind="stable")[:n_parents]
    n_young = n_survive - len(elites)
    if n_young >= len(offspring):
        young = np.arange(len(offspring))
    else:
        young = np.sort(offspring.argsort(kind="stable")[:n_young])
    return np.concatenate([elites, len(parents) + young])


@final
class ElitistReplacement(Survival):
    """Generational replacement with elites for pymoo.

    As pymoo's genetic algorithms merge them, the first `n_survive` individuals are the parents and the rest
    their offspring.

    Args:
        n_elites: Parents that pass untouched.

    Raises:
        AlgorithmError: `n_elites` is negative.
    """

    def __init__(self, n_elites: int = 2) -> None:
        super().__init__(filter_infeasible=False)
        if n_elites < 0:
            raise AlgorithmError(f"ElitistReplacement: n_elites is {n_elites!r}, expected a number of at least 0.")
        self.n_elites = n_elites

    def _do(self, problem: Any, pop: Any, *args: Any, n_survive: int, **kwargs: Any) -> Any:
        J = cost.of_population(pop)
        return pop[survivors(J[:n_survive], J[n_survive:], self.n_elites, n_survive)]
