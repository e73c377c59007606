"""Solvers of the users' own, by import path."""

import copy
import inspect
from collections.abc import Callable
from functools import partial
from typing import Any, final

import numpy as np

from robolaser.algorithms.algorithm_spec import Request
from robolaser.algorithms.imported import EXPECTED, imported, keywords, made_with, nothing
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.pymoo_algorithm import IDLE_ROUNDS, PymooAlgorithm
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import NotAnAlgorithm, NothingAsked, SettingUnknown

SEARCHES = 2
"""Arguments of a function that searches: the evaluator and the seed. One that makes an algorithm needs none."""
OR = "a Solver's class or an instance, or a function search(evaluator, seed)"


@final
class Own(Solver):
    """What somebody wrote, under the name it was asked for by."""

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
        """Let it search, the global generators seeded, and begin anew with another seed whenever it returns.

        Raises:
            NothingAsked: It returns and returns without a candidate.
        """
        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import

        rng, idle = np.random.default_rng(seed), 0
        with seeded(seed):
            while idle < IDLE_ROUNDS:
                before = evaluator.evaluations
                self._search(evaluator, seed)
                idle = idle + 1 if evaluator.evaluations == before else 0
                seed = int(rng.integers(1, 2**31))
        raise NothingAsked(idle)

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """What it says itself."""
        return self._refuses(problem)


def own(request: Request) -> Solver:
    """Make a solver of what lies at an import path.

    Raises:
        NotImportable, AttributeLacking: It is not there.
        NotAnAlgorithm: It cannot search.
        SettingUnknown, SettingsRefused: It cannot be made with these settings.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    found = imported(request)
    if callable(found) and not inspect.isclass(found) and _needs(found) == SEARCHES:
        return Own(request.text, _title(found, request), _with_settings(request, found))
    if isinstance(found, Solver | Algorithm):
        made_with(request, nothing)
        made, make = found, partial(copy.deepcopy, found)
    elif callable(found):
        made, make = made_with(request, found), partial(made_with, request, found)
    else:
        raise NotAnAlgorithm(request.text, found, f"{EXPECTED}, {OR}")
    if isinstance(made, Algorithm):
        return PymooAlgorithm(request.text, _title(found, request), make)
    if not isinstance(made, Solver):
        raise NotAnAlgorithm(request.text, made, f"{EXPECTED}, {OR}")
    title = getattr(made, "title", "") or _title(found, request)
    return Own(request.text, title, lambda evaluator, seed: make().search(evaluator, seed), made.refuses)


def _needs(function: Callable[..., Any]) -> int:
    try:
        parameters = inspect.signature(function).parameters.values()
    except ValueError:  # of some that are built in nothing is known
        return 0
    return sum(p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters)


def _with_settings(request: Request, search: Callable[..., None]) -> Callable[[BudgetedEvaluator, int], None]:
    known, takes_all = keywords(search)
    for name in request.settings:
        if name not in known[SEARCHES:] and not takes_all:
            raise SettingUnknown(request.text, name, known[SEARCHES:])
    return partial(search, **request.settings)


def _title(found: Any, request: Request) -> str:
    """The first line of its docstring; an instance has its class's, which `inspect` would not take from bases."""
    text = inspect.cleandoc(found.__doc__ or "")
    return text.splitlines()[0].rstrip(".") if text else f"{request.attribute} of {request.name}"
