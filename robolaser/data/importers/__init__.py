"""Importers, one file each: from files of other programs to a data set.

A new file in this folder takes part without an edit; an installed package announces its importers by entry points in
the group `robolaser.importers`.

Raises (every function that reads or chooses): DataError with file, row and column of a fault; UsageError with the
option that is missing or makes no sense; DependencyMissing where a file needs a package that is not installed.
"""

import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Final

from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.errors import UsageError, near, unreadable
from robolaser.plugins import announced

GROUP: Final = "robolaser.importers"  # entry points under which installed packages announce importers


@cache
def importers() -> Mapping[str, type[Importer]]:
    """Every importer by name: ours and those that installed packages announce.

    Raises:
        PluginError: A package's importer cannot be used.
    """
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    found = [kind for kind in Importer.__subclasses__() if kind.__module__.startswith(f"{__name__}.")]
    ours = {kind.name: kind for kind in sorted(found, key=lambda kind: kind.name)}
    return ours | announced(GROUP, Importer, taken=ours, required=["title"])


def importer_for(paths: Sequence[Path], kind: str | None = None) -> Importer:
    """The importer of that name or, without a name, the only one that recognises all files.

    Raises:
        DataError: A file is not there.
        UsageError: There is no such importer, or more than one; or no file is named.
        PluginError: An installed package's importer cannot be used.
    """
    known = importers()
    if not paths:
        raise UsageError("Name a file or folder to import.")
    for path in paths:
        if not path.exists():
            raise unreadable(path, "no such file or folder")
    if kind is not None:
        if kind not in known:
            raise UsageError(f"No importer '{kind}'.{near(kind, known)}")
        return known[kind]()
    made = [importer() for importer in known.values()]
    fitting = [importer for importer in made if all(map(importer.recognises, paths))]
    if len(fitting) == 1:
        return fitting[0]
    what = ", ".join(f"'{path}'" for path in paths)
    names = ", ".join(importer.name for importer in fitting)
    why = f"Several importers recognise {what}: {names}." if fitting else f"No importer recognises {what}."
    either = "the files in the folder, or " if not fitting and any(path.is_dir() for path in paths) else ""
    raise UsageError(f"{why} Name {either}one with --kind, see `robolaser list importers`.")


__all__ = ["ImportOptions", "Imported", "Importer", "importer_for", "importers"]
