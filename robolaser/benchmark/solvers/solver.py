"""A solver of a benchmark: a search method with all its settings."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem

ROUNDING = 1e-12  # of the distance between the bounds: a candidate outside by no more counts as on the bound
ONE_OBJECTIVE = "it minimises one objective, and the problem has several"
REAL = "its candidates are real numbers, and the problem's variables are not"

Search = Callable[[BudgetedEvaluator, int], None]
"""Searches for the lowest cost until done or until the evaluator raises `BudgetExhausted`, which it never catches.

Costs and residuals come from the evaluator only, all randomness from the seed, at least 1: the same seed evaluates the
same candidates in the same order.
"""
RefusalReason = Callable[[BenchmarkProblem], str | None]  # why a solver does not apply to a problem; None if it does


def one_objective_of_reals(problem: BenchmarkProblem) -> str | None:
    """One objective of real variables."""
    if problem.mixed or problem.discrete:
        return REAL
    return None if problem.n_obj == 1 else ONE_OBJECTIVE


@final
@dataclass(frozen=True, eq=False)
class Solver:
    """A search method with all its settings."""

    name: str  # given by the user, `de` or `rcga:b=2`; unique in a benchmark
    title: str  # a description
    search: Search  # the method
    refuses: RefusalReason = lambda problem: None  # reason why it does not apply to a problem
    knows_budget: bool = False  # whether its search depends on the budget, so that no run is a part of a longer one


def within(x: Array, problem: BenchmarkProblem) -> Array:
    """Candidates (c, d), moved onto a bound if outside by rounding only; others are unchanged, even outside."""
    inside = np.clip(x, problem.lower, problem.upper)
    return np.where(np.abs(x - inside) <= ROUNDING * (problem.upper - problem.lower), inside, x)
