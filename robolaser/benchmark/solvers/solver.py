"""The abstract solver of a benchmark."""

from abc import ABC, abstractmethod

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem

ROUNDING = 1e-12
"""Share of the distance between the bounds: a candidate outside by no more was meant to lie on the bound."""
ONE_OBJECTIVE = "it minimises one objective, and the problem has several"
REAL = "its candidates are real numbers, and the problem's variables are not"


class Solver(ABC):
    """A search method with all its settings.

    Attributes:
        name: As the user named it, `de` or `rcga:b=2`; unique in a benchmark.
        title: A description for a person.
        knows_budget: Does it search differently with another budget, so that no run of it is a part of a longer one?
    """

    name: str
    title: str
    knows_budget: bool = False

    @abstractmethod
    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Look for the lowest cost until done or until the evaluator raises `BudgetExhausted`; never catch that.

        All randomness comes from `seed`: the same seed evaluates the same candidates in the same order.

        Args:
            evaluator: Of the problem; costs and residuals are taken from it and from nothing else.
            seed: Seed of this run, at least 1.
        """

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """Why the solver does not apply to a problem; None if it does. By default it takes one objective of reals."""
        if problem.mixed or problem.discrete:
            return REAL
        return None if problem.n_obj == 1 else ONE_OBJECTIVE


def within(x: Array, problem: BenchmarkProblem) -> Array:
    """Candidates (c, d) with those meant to lie on a bound moved onto it; the others stay, even outside."""
    inside = np.clip(x, problem.lower, problem.upper)
    return np.where(np.abs(x - inside) <= ROUNDING * (problem.upper - problem.lower), inside, x)
