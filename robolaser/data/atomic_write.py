"""Files that are written whole or not at all: a full disk or a power cut leaves what was there before.

Files that belong together are staged beside what they will replace; a journal then names them all, which makes them
count. Whoever is killed while they are renamed leaves the journal, and whoever reads the folder next does the rest.
"""

import fcntl
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from robolaser.bounded_reading import read_json
from robolaser.errors import DataError, OutputError, unwritable

JOURNAL = ".robolaser-writing.json"
"""{"rename": {temporary: name}, "delete": [name]}, below the folder that it lies in."""

STAGED = ".robolaser~"
"""How the names of files begin that are still being written: those of a process that was killed stay."""


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all: a full disk or a power cut leaves what was there before.

    Raises:
        OutputError: The disk or the rights say no.
    """
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """As `write_text`, for bytes."""
    with written_whole(path) as file:
        file.write(data)


Contents = bytes | Callable[[], bytes] | Path
"""Of a file: its bytes, what gives them, or a whole file below the same folder that becomes it."""


def write_together(folder: Path, files: Mapping[str, Contents], delete: Sequence[str] = ()) -> None:
    """Write files that belong together: all or none, wherever the disk fills or the process is killed.

    Args:
        folder: Their folder.
        files: What they hold, by name; those in folders below as images/p001.png.
        delete: Names of files that go with what they belonged to.

    Raises:
        OutputError: The disk or the rights say no.
    """
    if not files and not delete:
        return
    finish_writing(folder)  # its journal would be overwritten
    staged = {os.path.relpath(data, folder): name for name, data in files.items() if isinstance(data, Path)}
    try:
        for name, data in files.items():
            if isinstance(data, Path):
                continue
            with _beside(folder / name, keep=True) as file:
                staged[os.path.relpath(file.name, folder)] = name
                file.write(data() if callable(data) else data)
        write_text(
            folder / JOURNAL, json.dumps({"rename": staged, "delete": [name for name in delete if name not in files]})
        )
    except BaseException:
        for temporary in () if (folder / JOURNAL).is_file() else staged:  # once it is there, they count
            with suppress(OSError):
                (folder / temporary).unlink(missing_ok=True)
        raise
    finish_writing(folder)


@contextmanager
def locked(folder: Path) -> Iterator[bool]:
    """Lock a folder, and say whether no other process has; the system lets go of it when this one ends, however."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        free = True
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            free = False
        yield free
    finally:
        os.close(handle)


def clear_staged(folder: Path) -> None:
    """Remove what killed processes had begun to write into a folder that is locked, and finished writing."""
    for left in folder.glob(f"{STAGED}*"):
        with suppress(OSError):
            left.unlink()


def finish_for_the_dead(folder: Path) -> None:
    """As `finish_writing`, unless who decided it is alive and still does it.

    Raises:
        OutputError: The disk or the rights say no.
    """
    if (folder / JOURNAL).is_file():
        with locked(folder) as free:
            if free:
                finish_writing(folder)


def finish_writing(folder: Path) -> None:
    """Do what a process had decided to write into a folder when it was killed.

    Raises:
        OutputError: The disk or the rights say no.
    """
    journal = folder / JOURNAL
    if not journal.is_file():
        return
    try:
        steps = read_json(journal)
        renamed, deleted = dict(steps["rename"]), list(steps["delete"])
        homes = {(folder / name).parent.resolve() for name in (*renamed, *renamed.values(), *deleted)}
    except (DataError, KeyError, TypeError, ValueError, OSError):
        return
    if not all(home.is_relative_to(folder.resolve()) for home in homes):
        return  # nobody of ours wrote it
    try:
        for name in deleted:
            (folder / name).unlink(missing_ok=True)
        for temporary, name in renamed.items():
            with suppress(FileNotFoundError):  # renamed before
                os.replace(folder / temporary, folder / name)
        journal.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(
            f"Cannot finish writing in {folder}: {error.strerror or error}. Everything is on the disk already; the"
            " next command that reads or writes there will finish."
        ) from None


@contextmanager
def written_whole(path: Path, *, mode: int = 0o644) -> Iterator[BinaryIO]:
    """Open a file to write to that is there once all is written, and not at all where something goes wrong.

    What was there before stays until then.

    Raises:
        OutputError: The disk or the rights say no.
    """
    with _beside(path) as file:
        yield file
        _settle(file, mode)
        os.replace(file.name, path)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise unwritable(path, error.strerror or str(error)) from None


@contextmanager
def _beside(path: Path, *, keep: bool = False) -> Iterator[BinaryIO]:
    """A file under a name of its own beside the one that it may become; gone afterwards unless renamed or kept."""
    with _naming(path):
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=STAGED, suffix=f".{path.name}")
        with open(name, "wb", opener=lambda *_: descriptor) as file:
            try:
                yield file
                if keep:
                    _settle(file)
            finally:
                if not keep:
                    Path(name).unlink(missing_ok=True)


def _settle(file: BinaryIO, mode: int = 0o644) -> None:
    """Flush a file to the disk, and let those read it who may: everybody, mostly."""
    file.flush()
    os.fsync(file.fileno())
    os.chmod(file.name, mode)
