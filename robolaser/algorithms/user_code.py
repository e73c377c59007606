"""Objects at import paths, and calls of them with typed settings."""

import copy
import importlib
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.errors import RobolaserError, UsageError, near

Given = Sequence[object] | Mapping[str, object]  # a user's list of things, or a mapping that names them


def imported(spec: AlgorithmSpec) -> Any:
    """Import the object at a path, also from the current directory; a `UsageError` if there is none, or it fails."""
    importlib.invalidate_caches()
    try:
        with _current_directory():
            found = importlib.import_module(spec.name)
    except (Exception, SystemExit) as error:  # any exception of a user's module
        raise UsageError(
            f"{spec.text}: module {spec.name} cannot be imported ({type(error).__name__}: {error})."
            " It must be in the current directory or be installed. Settings are written :key=value."
        ) from error
    for name in str(spec.attribute).split("."):
        if not hasattr(found, name):
            known = [known for known in dir(found) if not known.startswith("_")]
            raise UsageError(f"{spec.text}: {spec.name} has no '{spec.attribute}'.{near(str(spec.attribute), known)}")
        found = getattr(found, name)
    return found


def made(spec: AlgorithmSpec, make: Callable[..., Any], settings: Mapping[str, Any]) -> Any:
    """Call what a text names with these settings; a `UsageError` if it does not take one of them, or fails."""
    check_settings(spec, settings, make)
    try:
        with _current_directory():
            return make(**settings)
    except ImportError as error:
        raise UsageError(f"{spec.text} needs a package that is not installed ({error}).") from error
    except Exception as error:
        reason = str(error) if isinstance(error, RobolaserError) else f"{type(error).__name__}: {error}"
        raise UsageError(f"{spec.text} cannot be made. {reason.rstrip('.')}. Give it other settings.") from error


def check_settings(spec: AlgorithmSpec, settings: Mapping[str, Any], make: Callable[..., Any], first: int = 0) -> None:
    """Raise a `UsageError` if a class or function does not take a setting, not counting so many first arguments."""
    known, takes_all = keywords(make)
    for name in settings:
        if name not in known[first:] and not takes_all:
            raise UsageError(f"{spec.path} has no setting '{name}'.{near(name, known[first:])}")


def copies(spec: AlgorithmSpec, instance: Any) -> Callable[[], Any]:
    """A function that returns copies of an instance; a `UsageError` if settings were typed for it."""
    if spec.values:
        raise UsageError(f"{spec.text}: an instance has its settings already. Name its class instead.")
    return partial(copy.deepcopy, instance)


def by_name(given: Given, find: Callable[[Any, str], Any], hint: str) -> dict[str, Any]:
    """A user's list, or mapping, of things by name, each once.

    Raises:
        UsageError: Two have one name; `hint` says how to name them.
    """
    found: dict[str, tuple[object, Any]] = {}
    for name, one in given.items() if isinstance(given, Mapping) else [("", one) for one in given]:
        thing = find(one, str(name))
        first, _ = found.setdefault(thing.name, (one, thing))
        if not (first is one or (isinstance(first, str | Path) and first == one)):
            both = " and ".join(each if isinstance(each, str) else named(each) for each in (first, one))
            raise UsageError(f"{both} are called '{thing.name}', and results are stored by name. Name them: {hint}.")
    return {name: thing for name, (_, thing) in found.items()}


def title_of(thing: object, name: str) -> str:
    """The first line of the docstring of an object or its class, or of a partial's function; else the name."""
    text = inspect.cleandoc((thing.func if isinstance(thing, partial) else thing).__doc__ or "")
    return text.splitlines()[0].rstrip(".") if text else name


def named(thing: object) -> str:
    """The name of something, or of its class, without an address in memory."""
    return str(getattr(thing, "__name__", f"an object of class {type(thing).__name__}"))


def keywords(make: Callable[..., Any]) -> tuple[tuple[str, ...], bool]:
    """Names of the settings that a function or class takes, and whether it takes any others.

    pymoo's classes pass unknown settings to their bases, which ignore them: only those that a base class names count.
    """
    makers: list[Callable[..., Any]] = [make]
    if inspect.isclass(make) and any(base.__module__.startswith("pymoo.core") for base in make.__mro__):
        makers = [vars(base)["__init__"] for base in make.__mro__ if "__init__" in vars(base) and base is not object]
    known: dict[str, None] = {}
    for maker in makers:
        try:
            parameters = inspect.signature(maker).parameters.values()
        except ValueError:  # some built-in functions have no signature
            return (), True
        known |= {p.name: None for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
        if not any(p.kind is p.VAR_KEYWORD for p in parameters):
            return tuple(name for name in known if name != "self"), False
    return tuple(name for name in known if name != "self"), len(makers) == 1


@contextmanager
def _current_directory() -> Iterator[None]:
    """Look for modules in the current directory too, first, and no longer than needed."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)
