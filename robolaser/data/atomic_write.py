"""Files that are written whole or not at all: a full disk or a power cut leaves what was there before."""

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

from robolaser.errors import unwritable


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all: a full disk or a power cut leaves what was there before.

    Raises:
        OutputError: The disk or the rights say no.
    """
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """As `write_text`, for bytes."""
    write_together({path: data})


def write_together(files: Mapping[Path, bytes]) -> None:
    """Write files that belong together: all, or none where the disk has no room for them.

    Raises:
        OutputError: The disk or the rights say no.
    """
    with ExitStack() as open_files:
        staged = {path: open_files.enter_context(_beside(path)) for path in files}
        for path, file in staged.items():
            with _naming(path):
                file.write(files[path])
                _settle(file)
        for path, file in staged.items():
            with _naming(path):
                os.replace(file.name, path)


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """Open a file to write to that is there once all is written, and not at all where something goes wrong.

    What was there before stays until then.

    Raises:
        OutputError: The disk or the rights say no.
    """
    with _beside(path) as file, _naming(path):
        yield file
        _settle(file)
        os.replace(file.name, path)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise unwritable(path, error.strerror or str(error)) from None


@contextmanager
def _beside(path: Path) -> Iterator[BinaryIO]:
    """A file under a name of its own beside the one that it may become; gone afterwards unless it was renamed."""
    with _naming(path):
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    with open(name, "wb", opener=lambda *_: descriptor) as file:
        try:
            yield file
        finally:
            Path(name).unlink(missing_ok=True)


def _settle(file: BinaryIO) -> None:
    """Flush a file to the disk and let everybody read it."""
    file.flush()
    os.fsync(file.fileno())
    os.chmod(file.name, 0o644)
