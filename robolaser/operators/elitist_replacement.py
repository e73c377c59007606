"""Elitist replacement: the offspring replace all parents but the best."""

from typing import Any, final

import numpy as np
from pymoo.core.survival import Survival

from robolaser.arrays import Array, Ints
from robolaser.errors import AlgorithmError
from robolaser.operators import cost

RANKED = {"NSGA2", "SPEA2", "NicheGA"}
"""pymoo's algorithms, with all derived ones, whose tournaments read attributes written by their survival."""

BOUND_TO_THEIR_SURVIVAL = {"NSGA3", "NSDER", "RVEA", "CTAEA", "BRKGA", "OmniOptimizer"}
"""pymoo's algorithms, with all derived ones, that read their survival itself."""


def survivors(parents: Array, offspring: Array, n_elites: int, n_survive: int) -> Ints:
    """Survivors by the costs (p,) of parents and (o,) of offspring -> (n,) indices into both, joined.

    The best parents, best first, then the offspring in their order. If these are too many the worst
    offspring are dropped, if too few more parents stay. Of equals the earlier stays.
    """
    elites = _best(parents, max(min(n_elites, n_survive), n_survive - len(offspring)))
    n_young = n_survive - len(elites)
    young = np.arange(len(offspring)) if n_young >= len(offspring) else np.sort(_best(offspring, n_young))
    return np.concatenate([elites, len(parents) + young])


def _best(costs: Array, n: int) -> Ints:
    """The n lowest, lowest first, of equals the earlier; all, if there are fewer."""
    if not 0 < n < len(costs):
        return costs.argsort(kind="stable")[:n]
    low = (costs <= np.partition(costs, n - 1)[n - 1]).nonzero()[0]
    return np.asarray(low[costs[low].argsort(kind="stable")[:n]])


@final
class ElitistReplacement(Survival):
    """Generational replacement with elites for pymoo.

    Individuals of the algorithm's population are the parents, all others their offspring. Called without an algorithm
    it takes the first `n_survive` as parents, as merged by pymoo's genetic algorithms.

    Args:
        n_elites: Parents that pass unchanged.

    Raises:
        AlgorithmError: `n_elites` is negative; when called, if the algorithm needs results of its own survival (ranks,
            crowding, reference directions).

    Examples:
        >>> from robolaser.operators import ElitistReplacement
        >>> result = minimize(sphere, GA(survival=ElitistReplacement(n_elites=2)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(self, n_elites: int = 2) -> None:
        super().__init__(filter_infeasible=False)
        if n_elites < 0:
            raise AlgorithmError(f"ElitistReplacement: n_elites is {n_elites!r}, expected a number of at least 0.")
        self.n_elites = n_elites

    def _do(self, problem: Any, pop: Any, *args: Any, n_survive: int, algorithm: Any = None, **kwargs: Any) -> Any:
        refuse(algorithm)
        n_parents = _number_of_parents(pop, algorithm, n_survive)
        J = cost.of_population(pop)
        return pop[survivors(J[:n_parents], J[n_parents:], self.n_elites, n_survive)]


def _number_of_parents(pop: Any, algorithm: Any, n_survive: int) -> int:
    parents = getattr(algorithm, "pop", None)
    if parents is None or len(parents) > len(pop):
        return n_survive
    leads = all(one is other for one, other in zip(pop, parents, strict=False))
    return len(parents) if leads else n_survive


def refuse(algorithm: Any) -> None:
    """Raise an `AlgorithmError` if an algorithm reads attributes which its own survival writes on individuals."""
    if algorithm is None:
        return
    bases = _class_names(algorithm)
    ranked = bases & RANKED and "TournamentSelection" in _class_names(getattr(algorithm.mating, "selection", None))
    if ranked or bases & BOUND_TO_THEIR_SURVIVAL:
        name = type(algorithm).__name__
        raise AlgorithmError(
            f"ElitistReplacement cannot serve {name}, which needs what its own survival computes"
            f" ({'ranks for its tournaments' if ranked else 'its own state'}). Leave {name} its survival, or give"
            " ElitistReplacement to GA or RCGA."
        )


def _class_names(part: Any) -> set[str]:
    """Names of its class and all base classes: known without importing any."""
    return {base.__name__ for base in type(part).__mro__}
