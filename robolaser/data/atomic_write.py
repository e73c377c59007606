"""Files that are written whole or not at all: a full disk or a power cut leaves what was there before."""

import fcntl
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from robolaser.errors import unwritable

STAGED = ".robolaser~"
"""How the names of files begin that are still being written: those of a process that was killed stay."""


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all: a full disk or a power cut leaves what was there before.

    Raises:
        OutputError: The disk or the rights say no.
    """
    write_together(path.parent, {path.name: text.encode()})


Contents = bytes | Callable[[BinaryIO], object] | Path
"""Of a file: its bytes, what writes them, or a whole file below the same folder that becomes it."""


def written_later(read: Callable[[], bytes]) -> Contents:
    """The contents of a file that are not read before they are written."""
    return lambda file: file.write(read())


def write_together(
    folder: Path, files: Mapping[str, Contents], delete: Sequence[str] = (), *, mode: int = 0o644
) -> None:
    """Write files that belong together: on a full disk none of them, and each of them whole.

    All are staged; then what is to be deleted goes, and the files take their names, in their order: the last should be
    the one that names the others. Whoever is killed in between leaves files that are whole.

    Args:
        folder: Their folder.
        files: What they hold, by name; those in folders below as images/p001.png.
        delete: Names of files that go first: where files of an earlier result are among them, old and new ones are
            never there together.
        mode: Who may read them: everybody, mostly.

    Raises:
        OutputError: The disk or the rights say no.
    """
    staged = {name: data for name, data in files.items() if isinstance(data, Path)}
    try:
        for name, data in files.items():
            if not isinstance(data, Path):
                staged[name] = _stage(folder / name, data, mode)
        for name in delete:
            with naming(folder / name):
                (folder / name).unlink(missing_ok=True)
        for name in files:
            with naming(folder / name):
                os.replace(staged[name], folder / name)
    except BaseException:
        for temporary in staged.values():
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
        raise


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
def naming(path: Path) -> Iterator[None]:
    """Turn what the disk or the rights refuse into an `OutputError` that names the file or folder, as it is to be."""
    try:
        yield
    except OSError as error:
        path = path.with_name(path.name.removeprefix(STAGED)) if path.name.startswith(STAGED) else path
        raise unwritable(path, error.strerror or str(error)) from None


def _stage(path: Path, data: bytes | Callable[[BinaryIO], object], mode: int) -> Path:
    """Write a file under a name of its own beside the one that it is to become."""
    with naming(path):
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=STAGED, suffix=f".{path.name}")
        try:
            with open(name, "wb", opener=lambda *_: descriptor) as file:
                if isinstance(data, bytes):
                    file.write(data)
                else:
                    data(file)
                file.flush()
                os.fsync(file.fileno())
                os.chmod(name, mode)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    return Path(name)


def write_streamed(path: Path, head: Callable[[int], bytes], pieces: Iterable[NDArray[Any]]) -> int:
    """Write records, whole or not at all.

    Args:
        path: The file; what was there stays until all is written.
        head: Gives what stands before so many records; as long for one number as for any other.
        pieces: Records in order, each (n,).

    Returns:
        How many records were written.

    Raises:
        OutputError: The disk or its rights refuse.
    """
    count = 0

    def write(file: BinaryIO) -> None:
        nonlocal count
        file.write(head(0))
        for piece in pieces:
            file.write(np.ascontiguousarray(piece).data.cast("B"))
            count += len(piece)
        file.seek(0)
        file.write(head(count))

    write_together(path.parent, {path.name: write})
    return count
