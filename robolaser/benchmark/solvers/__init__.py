"""The solvers of a benchmark, by name or from a user."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from robolaser.algorithms import registry
from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.algorithms.user_code import check_settings, imported, title_of
from robolaser.benchmark.solvers.pymoo_algorithm import pymoo_solver, restarted
from robolaser.benchmark.solvers.searches import SEARCHES
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import UsageError

SOLVERS: Mapping[str, str] = {  # titles of ours by name
    registry.SCREENING: SEARCHES[registry.SCREENING].title,
    **{name: one.title for name, one in registry.ALGORITHMS.items()},
    **{name: one.title for name, one in SEARCHES.items()},
}
DEFAULT: tuple[str, ...] = tuple(SOLVERS)  # solvers that take part if none are named
ARGUMENTS = 2  # of a search function: the evaluator and the seed. A function that makes an algorithm needs none.


def solver_titles() -> Mapping[str, str]:
    """Titles of all solvers by name, with those of installed packages last."""
    return {**SOLVERS} | {name: one.title for name, one in registry.algorithms().items() if name not in SOLVERS}


def find(given: Any, name: str = "") -> Solver:
    """Make the solver that a text specifies, or of a function, class or instance, which may be given a name.

    Raises:
        UsageError: There is no such solver, it cannot search, or it cannot be made with these settings.
    """
    if not isinstance(given, str):
        name = name or getattr(given, "__name__", type(given).__name__)
        return _own(AlgorithmSpec(name, name), given)
    spec, name = AlgorithmSpec.of(given), name or given
    if spec.attribute is not None:
        if spec.name in solver_titles():
            raise UsageError(f"'{given}' cannot be read: '{spec.attribute}' is not a setting.")
        return _own(spec, imported(spec), name)
    if spec.name in SEARCHES:
        if spec.values:
            raise UsageError(f"{given}: {spec.name} has no settings, and its operators cannot be exchanged.")
        return replace(SEARCHES[spec.name], name=name)
    make = registry.maker_of(spec, known=solver_titles())
    title = solver_titles().get(spec.name) or f"pymoo's {spec.name}"
    parts = [f"{one.text} as {slot}" for slot, one in spec.operators.items()]
    parts += [f"{key}={value}" for key, value in spec.settings.items() if name != given]
    return pymoo_solver(name, f"{title} with {' and '.join(parts)}" if parts else title, make)


def _own(spec: AlgorithmSpec, found: Any, name: str = "") -> Solver:
    """A user's solver: a search function, or a pymoo algorithm."""
    name = name or spec.text
    if callable(found) and not inspect.isclass(found) and _needs(found) == ARGUMENTS:
        check_settings(spec, spec.values, found, ARGUMENTS)
        return Solver(name, title_of(found, name), partial(restarted, partial(found, **spec.values)))
    make = registry.maker_of(spec, found, expected=f"{registry.EXPECTED}, or a function search(evaluator, seed)")
    return pymoo_solver(name, title_of(found, name), make)


def _needs(function: Callable[..., Any]) -> int:
    try:
        parameters = inspect.signature(function).parameters.values()
    except ValueError:  # some built-in functions have no signature
        return 0
    return sum(p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters)
