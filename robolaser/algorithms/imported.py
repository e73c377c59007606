"""Algorithms of the users' own, by import path."""

import copy
import importlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from robolaser.algorithms.algorithm_spec import Request
from robolaser.errors import AttributeLacking, NotAnAlgorithm, NotImportable, SettingsRefused, SettingUnknown

EXPECTED = "a pymoo algorithm: its class, an instance, or a function that returns one"


def imported(request: Request) -> Any:
    """What is there. The current directory counts as a place to import from, from now on.

    Raises:
        NotImportable: The module is not there, or fails.
        AttributeLacking: It has no such attribute.
    """
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    importlib.invalidate_caches()
    try:
        found = importlib.import_module(request.name)
    except (Exception, SystemExit) as error:  # whatever somebody's module does when it is imported
        raise NotImportable(request.text, request.name, error) from error
    for name in str(request.attribute).split("."):
        if not hasattr(found, name):
            known = [known for known in dir(found) if not known.startswith("_")]
            raise AttributeLacking(request.text, request.name, str(request.attribute), known)
        found = getattr(found, name)
    return found


def algorithm_of(request: Request, found: Any) -> Any:
    """Make a pymoo algorithm of what was imported; of an instance a copy.

    Raises:
        NotAnAlgorithm: It is none, and makes none.
        SettingUnknown: It has no such setting.
        SettingsRefused: It cannot be made with them.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    if isinstance(found, Algorithm):
        made_with(request, nothing)
        return copy.deepcopy(found)
    made = made_with(request, found) if callable(found) else found
    if not isinstance(made, Algorithm):
        raise NotAnAlgorithm(request.text, made, EXPECTED)
    return made


def made_with(request: Request, make: Callable[..., Any]) -> Any:
    """Call what somebody wrote with the settings that are asked for.

    Raises:
        SettingUnknown: It does not take one of them.
        SettingsRefused: It fails.
    """
    known, takes_all = keywords(make)
    for name in request.settings:
        if name not in known and not takes_all:
            raise SettingUnknown(request.text.split("=")[0].rpartition(":")[0], name, known)
    try:
        return make(**request.settings)
    except Exception as error:
        raise SettingsRefused(request.text, error) from error


def keywords(make: Callable[..., Any]) -> tuple[tuple[str, ...], bool]:
    """Names of the settings that a function or class takes, and whether it takes any others.

    pymoo's classes hand unknown ones up until they get lost: there all that some base class knows counts, nothing else.
    """
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    makers: list[Callable[..., Any]] = [make]
    if inspect.isclass(make) and issubclass(make, Algorithm):
        makers = [vars(base)["__init__"] for base in make.__mro__ if "__init__" in vars(base) and base is not object]
    known: dict[str, None] = {}
    for maker in makers:
        try:
            parameters = inspect.signature(maker).parameters.values()
        except ValueError:  # of some that are built in nothing is known
            return (), True
        known |= {p.name: None for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
        if not any(p.kind is p.VAR_KEYWORD for p in parameters):
            return tuple(name for name in known if name != "self"), False
    return tuple(name for name in known if name != "self"), len(makers) == 1


def nothing() -> None:
    """What an instance takes for settings."""
