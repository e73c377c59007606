"""Solvers of the users' own, by import path."""

import copy
import inspect
from collections.abc import Callable
from functools import partial
from typing import Any, final

import numpy as np

from robolaser.algorithms.algorithm_spec import AlgorithmSpec
from robolaser.algorithms.settings import unknown_setting
from robolaser.algorithms.user_code import EXPECTED, keywords, made_with, no_settings, not_an_algorithm
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.pymoo_algorithm import IDLE_ROUNDS, PymooAlgorithm, idle_error
from robolaser.benchmark.solvers.solver import Solver

SEARCHES = 2
"""Arguments of a function that searches: the evaluator and the seed. A function that makes an algorithm has none."""
OR = "a Solver's class or an instance, or a function search(evaluator, seed)"


@final
class UserSolver(Solver):
    """A solver that a user wrote, under the name by which the user named it."""

    def __init__(
        self,
        name: str,
        title: str,
        search: Callable[[BudgetedEvaluator, int], None],
        refuses: Callable[[BenchmarkProblem], str | None] = lambda problem: None,
    ) -> None:
        self.name, self.title = name, title
        self._search, self._refuses = search, refuses

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search with global generators seeded, and begin anew with another seed whenever it returns."""
        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import

        rng, idle = np.random.default_rng(seed), 0
        with seeded(seed):
            while idle < IDLE_ROUNDS:
                before = evaluator.evaluations
                self._search(evaluator, seed)
                idle = idle + 1 if evaluator.evaluations == before else 0
                seed = int(rng.integers(1, 2**31))
        raise idle_error(idle)

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """What the user's solver says."""
        return self._refuses(problem)


def user_solver(spec: AlgorithmSpec, found: Any) -> Solver:
    """Make a solver of what a user wrote.

    Raises:
        UsageError: It cannot search, or cannot be made with these settings.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    if callable(found) and not inspect.isclass(found) and _needs(found) == SEARCHES:
        return UserSolver(spec.text, _title(found, spec), _with_settings(spec, found))
    if isinstance(found, Solver | Algorithm):
        made_with(spec, no_settings)
        made, make = found, partial(copy.deepcopy, found)
    elif callable(found):
        made, make = made_with(spec, found), partial(made_with, spec, found)
    else:
        raise not_an_algorithm(spec, found, f"{EXPECTED}, {OR}")
    if isinstance(made, Algorithm):
        return PymooAlgorithm(spec.text, _title(found, spec), make)
    if not isinstance(made, Solver):
        raise not_an_algorithm(spec, made, f"{EXPECTED}, {OR}")
    title = getattr(made, "title", "") or _title(found, spec)
    return UserSolver(spec.text, title, lambda evaluator, seed: make().search(evaluator, seed), made.refuses)


def _needs(function: Callable[..., Any]) -> int:
    try:
        parameters = inspect.signature(function).parameters.values()
    except ValueError:  # some built-in functions do not say
        return 0
    return sum(p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters)


def _with_settings(spec: AlgorithmSpec, search: Callable[..., None]) -> Callable[[BudgetedEvaluator, int], None]:
    known, takes_all = keywords(search)
    for name in spec.settings:
        if name not in known[SEARCHES:] and not takes_all:
            raise unknown_setting(spec.text, name, known[SEARCHES:])
    return partial(search, **spec.settings)


def _title(found: Any, spec: AlgorithmSpec) -> str:
    """The first line of its docstring; an instance has its class's, which `inspect` would not take from bases."""
    text = inspect.cleandoc(found.__doc__ or "")
    return text.splitlines()[0].rstrip(".") if text else f"{spec.attribute} of {spec.name}"
