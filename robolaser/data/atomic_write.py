"""Files that are written whole or not at all: a full disk or a power cut leaves what was there before."""

import fcntl
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from robolaser.errors import unwritable

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
    """Write files that belong together: on a full disk none of them, and each of them whole.

    All are staged; then what is to be deleted goes, and the files take their names, in their order: the last should be
    the one that names the others. Whoever is killed in between leaves files that are whole.

    Args:
        folder: Their folder.
        files: What they hold, by name; those in folders below as images/p001.png.
        delete: Names of files that go first: where files of an earlier result are among them, old and new ones are
            never there together.

    Raises:
        OutputError: The disk or the rights say no.
    """
    staged = {data: name for name, data in files.items() if isinstance(data, Path)}
    try:
        for name, data in files.items():
            if not isinstance(data, Path):
                with _beside(folder / name, keep=True) as file:
                    staged[Path(file.name)] = name
                    file.write(data() if callable(data) else data)
    except BaseException:
        for temporary in staged:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
        raise
    names = {name: temporary for temporary, name in staged.items()}
    with _naming(folder):
        for name in delete:
            (folder / name).unlink(missing_ok=True)
        for name in files:
            os.replace(names[name], folder / name)


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
    """Remove what killed processes had begun to write into a folder that is locked."""
    for left in folder.glob(f"{STAGED}*"):
        with suppress(OSError):
            left.unlink()


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
