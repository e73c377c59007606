"""Where machine code is kept: one folder for each version of the loops, of Python and of numba, on one machine."""

import hashlib
import os
import platform
import re
import shutil
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

FOLDER = "ROBOLASER_CACHE"  # environment variable: where to keep machine code instead of the user's cache folder
VERSIONS_KEPT = 4
PACKAGE = Path(__file__).parents[1]


@cache
def folder() -> Path:
    """Where the machine code of these sources is kept; a change in any loop, or in what it calls, is another folder.

    Raises:
        OSError: It cannot be made.
    """
    made_of = hashlib.sha256("\0".join((sys.version, version("numba"), platform.node(), str(PACKAGE))).encode())
    for source in sorted(_sources()):
        made_of.update(source.read_bytes())
    of_this_version = _root() / made_of.hexdigest()[:16]
    if not of_this_version.is_dir():
        of_this_version.mkdir(parents=True)
        _forget_old_versions()
    return of_this_version


def _sources() -> set[Path]:
    """All files of loops, and what they import of ours."""
    sources: set[Path] = set()
    waiting = list(PACKAGE.rglob("*_loops.py"))
    while waiting:
        source = waiting.pop()
        if source not in sources:
            sources.add(source)
            modules = re.findall(
                rf"^from {PACKAGE.name}\.([\w.]+) import", source.read_text(encoding="utf-8"), re.MULTILINE
            )
            files = (PACKAGE.joinpath(*module.split(".")).with_suffix(".py") for module in modules)
            waiting += [file for file in files if file.is_file()]
    return sources


def _root() -> Path:
    if FOLDER in os.environ:
        return Path(os.environ[FOLDER])
    caches = os.environ.get("XDG_CACHE_HOME") or ("~/Library/Caches" if sys.platform == "darwin" else "~/.cache")
    return Path(caches).expanduser() / "robolaser"


def _forget_old_versions() -> None:
    versions = sorted((path for path in _root().iterdir() if path.is_dir()), key=lambda path: path.stat().st_mtime)
    for old in versions[:-VERSIONS_KEPT]:
        shutil.rmtree(old, ignore_errors=True)
