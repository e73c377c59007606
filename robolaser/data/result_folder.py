"""Files written completely or not at all, and result folders: locked while a command replaces its own files."""

import fcntl
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from robolaser.bounded_reading import read_json
from robolaser.errors import DataError, OutputError, output_exists, unwritable

STAGED = ".robolaser~"  # prefix of files that are being written: those of a killed process remain


def write_text(path: Path, text: str) -> None:
    """Write a file completely or not at all: a full disk or a power cut leaves the previous one."""
    write_together(path.parent, {path.name: text.encode()})


Contents = bytes | Callable[[BinaryIO], object] | Path
"""Contents of a file: bytes, a function that writes them, or a complete file below the same folder to be renamed."""


def written_later(read: Callable[[], bytes]) -> Contents:
    """The contents of a file that are not read before they are written."""
    return lambda file: file.write(read())


def write_together(
    folder: Path, files: Mapping[str, Contents], delete: Sequence[str] = (), *, mode: int = 0o644
) -> None:
    """Write files that belong together: on a full disk none of them, and each of them completely.

    All are staged; then files are deleted, and the new ones get their names, in order: the last should be the one that
    names the others. A process that is killed in between leaves complete files.

    Args:
        folder: Their folder.
        files: Their contents, by name; in folders below as images/p001.png.
        delete: Names of files that are deleted first: with an earlier result's files among them, old and new ones
            never exist together.
        mode: Their permissions.
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
def naming(path: Path) -> Iterator[None]:
    """Raise errors of disk and permissions as an `OutputError` with the final name of the file or folder."""
    try:
        yield
    except OSError as error:
        path = path.with_name(path.name.removeprefix(STAGED)) if path.name.startswith(STAGED) else path
        raise unwritable(path, error.strerror or str(error)) from None


def _stage(path: Path, data: bytes | Callable[[BinaryIO], object], mode: int) -> Path:
    """Write a file under a temporary name in the folder of the final one."""
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
    """Write records, pieces (n,) in order, completely or not at all, and return their number.

    `head` is the header of so many records; its length does not depend on their number.
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


MANIFEST = ".robolaser.json"  # files of commands in a folder: {"format": …, "files": {name: command}}

FORMAT = "robolaser-results/1"


def json_text(contents: Mapping[str, Any]) -> str:
    """A JSON file of a result."""
    return json.dumps(contents, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


Claim = Callable[[Iterable[str]], list[str]]


@contextmanager
def results_in(
    folder: Path,
    *,
    command: str,
    files: Sequence[str],
    state: Sequence[str] = (),
    inputs: Sequence[Path] = (),
    over: Sequence[str] = (),
    force: bool = False,
) -> Iterator[Claim]:
    """Lock a folder for one command while it runs, and note the files that it writes as its own.

    Yields a function that claims further files, whose names the command learns later. It returns the names of the other
    files of earlier results.

    Args:
        folder: Created if it does not exist.
        command: The command's name.
        files: Names of all files that it may write, in folders below as images/p001.png.
        state: Names of files of an interrupted run, from which it resumes; the command manages these itself.
        inputs: Data sets, other folders and files that it reads.
        over: Commands whose results it may replace as if they were its own.
        force: Replace earlier results.

    Raises:
        OutputError: The folder or one of the files is an input or in one, the folder is not writable, is written to
            by another process, or holds a file of one of these names that this command did not write, or its earlier
            result without `force`.
    """
    _refuse_input(folder, files, inputs)
    with _locked(folder):
        known, own = _manifest(folder), dict[str, str]()
        cleared = set[Path]()

        def claim(names: Iterable[str]) -> list[str]:
            new = dict.fromkeys(names, command)
            homes = {folder, *((folder / name).parent for name in new)} - cleared
            for left in (left for home in homes for left in home.glob(f"{STAGED}*")):
                with suppress(OSError):  # staged files of killed processes
                    left.unlink()
            cleared.update(homes)
            for name in new:
                if name not in own and os.path.lexists(folder / name):
                    _refuse_what_is_not_its_own(folder / name, known.get(name), (command, *over))
                    if not (force or name in state):
                        raise output_exists(folder / name)
            _note(folder, known | own | new)
            own.update(new)
            return [name for name, owner in known.items() if owner in (command, *over) and name not in own]

        claim((*files, *state))
        try:
            yield claim
        finally:
            left = {name: owner for name, owner in (known | own).items() if (folder / name).exists()}
            with suppress(OutputError):  # on a full disk the manifest still names the planned files
                _note(folder, left)


def write_results(folder: Path, contents: Mapping[str, str | Contents | None]) -> None:
    """Write files by their names over an earlier result; those that are None are deleted, with folders left empty.

    A full disk leaves the earlier result; a kill never leaves files of both. The last file, which may name the others,
    is deleted first and written last.
    """
    there = {name: file for name, file in contents.items() if file is not None}
    files = {name: file.encode() if isinstance(file, str) else file for name, file in there.items()}
    for home in {(folder / name).parent for name in files}:
        make_folder(home)
    write_together(folder, files, list(contents)[::-1])
    for name in contents.keys() - files.keys():
        with suppress(OSError):  # its folder is not empty
            os.removedirs((folder / name).parent)


def _refuse_input(folder: Path, files: Sequence[str], inputs: Sequence[Path]) -> None:
    """Refuse to write results into or over inputs."""
    for written in (folder, *(folder / name for name in files)):
        if any(written.resolve().is_relative_to(source.resolve()) for source in inputs):
            raise OutputError(
                f"{written} is an input of this command or is inside one, and is not changed. Choose another --output."
            )


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Create a folder and lock it; a new folder that is empty in the end is removed.

    The system releases the lock when this process ends, however.
    """
    is_new = not os.path.lexists(folder)
    make_folder(folder)
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            busy = f"Another robolaser command is writing into {folder}. Wait for its end, or choose another folder."
            raise OutputError(busy) from None
        yield
    finally:
        os.close(handle)
        if is_new:
            with suppress(OSError):  # it is not empty
                folder.rmdir()


def make_folder(folder: Path) -> None:
    """Create a folder and its parents, and check that it is writable before any work is done."""
    with naming(folder):
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()


def _refuse_what_is_not_its_own(path: Path, owner: str | None, commands: Sequence[str]) -> None:
    if owner in commands and path.is_file() and not path.is_symlink():
        return
    whose = f"a result of robolaser {owner}" if owner not in (None, *commands) else "not its own earlier result"
    raise OutputError(
        f"robolaser {commands[0]} would write {path}, but what is there is {whose}; it stays as it is, with --force"
        " too. Choose another --output, or move the file away."
    )


def _manifest(folder: Path) -> dict[str, str]:
    """The command that wrote each file; a manifest that cannot be read owns nothing."""
    try:
        files = read_json(folder / MANIFEST)["files"].items()
    except (DataError, LookupError, TypeError, AttributeError):
        return {}
    return {name: owner for name, owner in files if isinstance(owner, str)}


def _note(folder: Path, owners: Mapping[str, str]) -> None:
    if owners:
        write_text(folder / MANIFEST, json_text({"format": FORMAT, "files": dict(sorted(owners.items()))}))
    else:
        (folder / MANIFEST).unlink(missing_ok=True)
