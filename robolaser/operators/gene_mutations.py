"""Mutations that forget a gene: it becomes one of its bounds, or anything between them."""

from abc import ABC, abstractmethod
from typing import Any, final

import numpy as np
from pymoo.core.mutation import Mutation

from robolaser.arrays import Array
from robolaser.operators.bounds import check_probability, finite_bounds, within_bounds


class _GeneMutation(Mutation, ABC):
    """Some genes get new values, whatever they were."""

    def __init__(self, prob_var: float = 0.1, *, prob: float = 1.0, **kwargs: Any) -> None:
        super().__init__(prob=prob, prob_var=prob_var, **kwargs)
        check_probability(self.name, "prob_var", prob_var)

    def _do(self, problem: Any, X: Array, *args: Any, random_state: Any = None, **kwargs: Any) -> Array:
        bounds = finite_bounds(problem, self.name)
        mutated = random_state.random(X.shape) < self.get_prob_var(problem, size=len(X))[:, None]
        return np.where(
            mutated, self._values(*bounds, random_state.random(X.shape)), within_bounds(X.astype(np.float64), problem)
        )

    @abstractmethod
    def _values(self, lower: Array, upper: Array, draws: Array) -> Array:
        """New values (n, d) within bounds (d,) from draws at [0, 1), (n, d)."""


@final
class BoundaryMutation(_GeneMutation):
    """Genes move onto one of their bounds, either with probability one half. GENOCOP's, Michalewicz 1996.

    For problems whose optimum lies on bounds. Draws random((n, d)) < prob_var, the genes; random((n, d)) < 0.5, up.

    Args:
        prob_var: Probability that a gene is moved.
        prob: Probability that an individual takes part.

    Raises:
        AlgorithmError: prob_var is no probability; when called, if a variable has no finite bounds.

    Examples:
        >>> from robolaser.operators import BoundaryMutation
        >>> result = minimize(sphere, GA(mutation=BoundaryMutation(prob_var=0.02)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def _values(self, lower: Array, upper: Array, draws: Array) -> Array:
        return np.where(draws < 0.5, upper, lower)


@final
class UniformMutation(_GeneMutation):
    """Genes become any value between their bounds, all alike. GENOCOP's, Michalewicz 1996.

    Draws random((n, d)) < prob_var, the genes; random((n, d)), the values.

    Args:
        prob_var: Probability that a gene is moved.
        prob: Probability that an individual takes part.

    Raises:
        AlgorithmError: prob_var is no probability; when called, if a variable has no finite bounds.

    Examples:
        >>> from robolaser.operators import UniformMutation
        >>> result = minimize(sphere, GA(mutation=UniformMutation(prob_var=0.05)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def _values(self, lower: Array, upper: Array, draws: Array) -> Array:
        return np.clip(lower + draws * (upper - lower), lower, upper)
