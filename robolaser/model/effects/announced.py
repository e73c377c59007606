"""Effects that other installed packages bring: each announces its classes under the entry-point group."""

import inspect
from collections.abc import Iterable
from importlib.metadata import EntryPoint, entry_points
from typing import Final

from robolaser.errors import AnnouncedTwice, AnnouncementUnusable
from robolaser.model.effects.effect import Effect

GROUP: Final = "robolaser.model.effects"
SAID: Final = ("name", "title", "reference", "stage")


def announced(ours: Iterable[type[Effect]]) -> tuple[type[Effect], ...]:
    """Load the effects of all installed packages, in the order of their names.

    Args:
        ours: Effects whose names are taken.

    Raises:
        AnnouncementUnusable: A package announces something that cannot be loaded, or is no effect.
        AnnouncedTwice: The name is taken, by us or by another package.
    """
    owners = {kind.name: "robolaser" for kind in ours}
    found = []
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, entry.value)):
        kind = _loaded(entry)
        if kind.name in owners:
            raise AnnouncedTwice(kind.name, _package(entry), entry.value, owners[kind.name])
        owners[kind.name] = _package(entry)
        found.append(kind)
    return tuple(sorted(found, key=lambda kind: kind.name))


def _loaded(entry: EntryPoint) -> type[Effect]:
    try:
        kind = entry.load()
    except Exception as wrong:  # whatever somebody's module does when it is imported
        raise AnnouncementUnusable(_package(entry), entry.value, f"{type(wrong).__name__}: {wrong}") from wrong
    if not (isinstance(kind, type) and issubclass(kind, Effect)):
        raise AnnouncementUnusable(_package(entry), entry.value, f"it is {kind!r} and no subclass of Effect")
    missing = [word for word in SAID if not hasattr(kind, word)] + sorted(kind.__abstractmethods__)
    if inspect.isabstract(kind) or missing:
        raise AnnouncementUnusable(_package(entry), entry.value, f"it does not say its {', '.join(missing)}")
    return kind


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else "an unnamed package"
