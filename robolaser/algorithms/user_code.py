"""Algorithms that users wrote themselves, found by import path."""

import copy
import importlib
import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from robolaser.algorithms.algorithm_spec import AlgorithmSpec
from robolaser.algorithms.settings import not_made, unknown_setting
from robolaser.errors import UsageError, near

EXPECTED = "a pymoo algorithm: its class, an instance, or a function that returns one"


def imported(spec: AlgorithmSpec) -> Any:
    """Import what lies at a path; modules in the current directory count.

    Raises:
        UsageError: The module does not exist or fails, or it has no such attribute.
    """
    importlib.invalidate_caches()
    try:
        with _current_directory():
            found = importlib.import_module(spec.name)
    except (Exception, SystemExit) as error:  # whatever a user's module does when it is imported
        raise UsageError(
            f"{spec.text}: module {spec.name} cannot be imported ({type(error).__name__}: {error})."
            " It has to lie in the current directory or be installed. Settings are written :key=value."
        ) from error
    for name in str(spec.attribute).split("."):
        if not hasattr(found, name):
            known = [known for known in dir(found) if not known.startswith("_")]
            hint = near(str(spec.attribute), known)
            raise UsageError(f"{spec.text}: {spec.name} has no '{spec.attribute}'.{hint}")
        found = getattr(found, name)
    return found


def user_algorithm(spec: AlgorithmSpec) -> Any:
    """Import a pymoo algorithm and make it; an instance is copied.

    Raises:
        UsageError: It is not there, is no algorithm and makes none, or cannot be made with its settings.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    found = imported(spec)
    if isinstance(found, Algorithm):
        made_with(spec, no_settings)
        return copy.deepcopy(found)
    made = made_with(spec, found) if callable(found) else found
    if not isinstance(made, Algorithm):
        raise not_an_algorithm(spec, made, EXPECTED)
    return made


def made_with(spec: AlgorithmSpec, make: Callable[..., Any]) -> Any:
    """Call a user's class or function with the settings that are given.

    Raises:
        UsageError: It does not take one of them, or fails.
    """
    known, takes_all = keywords(make)
    for name in spec.settings:
        if name not in known and not takes_all:
            raise unknown_setting(spec.path, name, known)
    try:
        with _current_directory():
            return make(**spec.settings)
    except Exception as error:
        raise not_made(spec.text, error) from error


def keywords(make: Callable[..., Any]) -> tuple[tuple[str, ...], bool]:
    """Names of the settings that a function or class takes, and whether it takes any others.

    pymoo's classes pass unknown settings to their bases, which ignore them: only those that a base class names count.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    makers: list[Callable[..., Any]] = [make]
    if inspect.isclass(make) and issubclass(make, Algorithm):
        makers = [vars(base)["__init__"] for base in make.__mro__ if "__init__" in vars(base) and base is not object]
    known: dict[str, None] = {}
    for maker in makers:
        try:
            parameters = inspect.signature(maker).parameters.values()
        except ValueError:  # some built-in functions do not say
            return (), True
        known |= {p.name: None for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
        if not any(p.kind is p.VAR_KEYWORD for p in parameters):
            return tuple(name for name in known if name != "self"), False
    return tuple(name for name in known if name != "self"), len(makers) == 1


def no_settings() -> None:
    """The settings that an instance takes."""


def not_an_algorithm(spec: AlgorithmSpec, found: object, expected: str) -> UsageError:
    """What was imported cannot search."""
    return UsageError(f"{spec.text} is {found!r:.80} and cannot search. Expected {expected}.")


@contextmanager
def _current_directory() -> Iterator[None]:
    """Look for modules in the current directory too, first, and no longer than needed."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)
