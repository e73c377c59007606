"""Solvers of the users' own."""

import copy
import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, final

import numpy as np

from robolaser.algorithms.registry import EXPECTED, maker_of, not_an_algorithm
from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.algorithms.user_code import imported, keywords, made
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.pymoo_algorithm import IDLE_ROUNDS, PymooAlgorithm, idle_error
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import UsageError, near

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


def user_solver(given: Any, name: str = "") -> Solver:
    """Make a solver of what a user wrote: a text `package.module:attribute` with settings, or the thing itself.

    Raises:
        UsageError: It cannot search, or cannot be made with these settings.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    if isinstance(given, str):
        spec, found = AlgorithmSpec.of(given), imported(AlgorithmSpec.of(given))
    else:
        name = name or getattr(given, "__name__", type(given).__name__)
        spec, found = AlgorithmSpec(name, name), given
    name, title = name or spec.text, _title(found, name or spec.text)
    if callable(found) and not inspect.isclass(found) and _needs(found) == SEARCHES:
        return UserSolver(name, title, _with_settings(spec, found))
    if isinstance(found, Algorithm):
        if spec.settings or spec.operators:
            raise UsageError(f"{spec.text}: an instance has its settings already. Name its class instead.")
        return PymooAlgorithm(name, title, partial(_copy, found))
    if callable(found) and not isinstance(found, Solver):
        if spec.operators or (inspect.isclass(found) and issubclass(found, Algorithm)):
            make = maker_of(spec) if isinstance(given, str) else partial(_make, found, spec.settings)
            return PymooAlgorithm(name, title, make)
        found_now = made(spec.text, found, spec.settings)
        if isinstance(found_now, Algorithm):
            return PymooAlgorithm(name, title, partial(_make, found, spec.settings))
        remade: Callable[[], Any] = partial(made, spec.text, found, spec.settings)
    else:
        found_now, remade = found, partial(copy.deepcopy, found)
    if not isinstance(found_now, Solver):
        raise not_an_algorithm(spec.text, found_now, f"{EXPECTED}, {OR}")
    return UserSolver(name, getattr(found_now, "title", "") or title, partial(_search, remade), found_now.refuses)


def _copy(found: Any, n_obj: int) -> Any:
    """One more of an instance, whatever the number of objectives."""
    return copy.deepcopy(found)


def _make(make: Callable[..., Any], settings: Mapping[str, Any], n_obj: int) -> Any:
    """An instance of a class, or what a function makes, whatever the number of objectives."""
    return made(getattr(make, "__name__", "the function"), make, settings)


def _search(make: Callable[[], Any], evaluator: BudgetedEvaluator, seed: int) -> None:
    """The search of a solver that is made anew each time."""
    make().search(evaluator, seed)


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
            raise UsageError(f"{spec.path} has no setting '{name}'.{near(name, known[SEARCHES:])}")
    return partial(search, **spec.settings)


def _title(found: Any, name: str) -> str:
    """The first line of its docstring; an instance has its class's, which `inspect` would not take from bases."""
    text = inspect.cleandoc(found.__doc__ or "")
    return text.splitlines()[0].rstrip(".") if text else name
