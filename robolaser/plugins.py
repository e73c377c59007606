"""Other installed packages: classes that they announce to our families, and optional extras."""

import inspect
from collections.abc import Iterable, Sequence
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

from robolaser.errors import DependencyMissing, PluginError

T = TypeVar("T")


def extra(module: str, missing: str) -> Any:
    """A module of an optional package, loaded now.

    Raises:
        DependencyMissing: With that sentence, if it is not installed; or it is, but does not load.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError:
        raise DependencyMissing(missing) from None
    except ImportError as error:
        raise DependencyMissing(f"{module} is installed, but does not load: {error}. Install what it lacks.") from None


def announced(
    group: str, base: type[T], *, taken: Iterable[str], name: str = "name", required: Sequence[str] = ()
) -> dict[str, type[T]]:
    """Load the classes of all installed packages that are announced under an entry-point group.

    Args:
        group: The family's group, such as `robolaser.effects`.
        base: The family's abstract class.
        taken: Names of our own members.
        name: Attribute of a class that holds its name; if it is empty, the entry point's name counts.
        required: Further attributes of a complete class, besides `name` and abstract methods.

    Returns:
        The classes in the order of their names.

    Raises:
        PluginError: A class cannot be loaded, is incomplete or of another family, or its name is taken, by one of ours
            or by another package.
    """
    owners = dict.fromkeys(taken, "robolaser")
    found: dict[str, type[T]] = {}
    for entry in sorted(entry_points(group=group), key=lambda entry: (entry.name, entry.value)):
        member = _load(entry, base, [name, *required] if name else required)
        key = str(getattr(member, name)) if name else entry.name
        if key in owners:
            raise PluginError(
                f"The installed package {_package(entry)} announces {entry.value} as the {_family(group)} '{key}', but"
                f" {owners[key]} has one of that name: rename one of them, or uninstall {_package(entry)}."
            )
        owners[key] = _package(entry)
        found[key] = member
    return dict(sorted(found.items()))


def _load(entry: EntryPoint, base: type[T], required: Sequence[str]) -> type[T]:
    try:
        member = entry.load()
    except Exception as error:  # any exception of that module
        raise _unusable(entry, base, f"{type(error).__name__}: {error}") from error
    if not (isinstance(member, type) and issubclass(member, base)):
        raise _unusable(entry, base, f"it is {member!r}, not a subclass of {base.__name__}")
    missing = [word for word in required if not hasattr(member, word)]
    missing += sorted(set(getattr(member, "__abstractmethods__", ())) - set(missing))
    if inspect.isabstract(member) or missing:
        raise _unusable(entry, base, f"it does not define {', '.join(missing)}")
    return member


def _unusable(entry: EntryPoint, base: type, reason: str) -> PluginError:
    return PluginError(
        f"The installed package {_package(entry)} announces {entry.value} under {entry.group}, but it cannot be used:"
        f" {reason}. Expected a complete subclass of {base.__module__}.{base.__qualname__}: correct or uninstall"
        f" {_package(entry)}."
    )


def _family(group: str) -> str:
    """One member of a group: robolaser.effects -> effect."""
    return group.rpartition(".")[2].removesuffix("s")


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else "an unnamed package"
