"""A folder that a command writes its results to: locked meanwhile, and only its own earlier results are replaced."""

import fcntl
import json
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from robolaser.data.atomic_write import write_text, write_together
from robolaser.errors import OutputError, unwritable

MANIFEST = ".robolaser.json"
"""What commands wrote into a folder: {"format": …, "files": {name: command}}."""

FORMAT = "robolaser-results/1"


@contextmanager
def results_in(
    folder: Path,
    *,
    command: str,
    files: Sequence[str],
    state: Sequence[str] = (),
    inputs: Sequence[Path] = (),
    force: bool = False,
) -> Iterator[None]:
    """Keep a folder for one command while it runs, and note what it leaves there as its own.

    Args:
        folder: Created where it is not there.
        command: The command's name.
        files: Names of all that it may write.
        state: Names of what it leaves when it is stopped, to be gone on with; the command looks after those itself.
        inputs: Data sets and other folders that it reads.
        force: Replace earlier results of this command.

    Raises:
        OutputError: The folder is one of the inputs, cannot be written to, is written to by another process, or holds
            a file of one of these names that this command did not write, or its earlier result without `force`.
    """
    refuse_input(folder, inputs)
    make_folder(folder)
    with _locked(folder):
        known = _manifest(folder)
        for name in (*files, *state):
            if os.path.lexists(folder / name):
                _refuse_what_is_not_its_own(folder / name, known.get(name), command)
        for name in files:
            if (folder / name).exists() and not force:
                raise OutputError(
                    f"{folder / name} holds a result already. Choose another --output, or overwrite it with --force."
                )
        names = (*files, *state)
        _note(folder, known | dict.fromkeys(names, command))
        try:
            yield
        finally:
            left = {name: command for name in names if (folder / name).exists()}
            _note(folder, {name: owner for name, owner in known.items() if name not in names} | left)


def write_results(folder: Path, texts: Mapping[str, str | None]) -> None:
    """Write files by their names, all or none; what is None this time goes, if an earlier result left it.

    Raises:
        OutputError: The disk or the rights say no.
    """
    write_together({folder / name: text.encode() for name, text in texts.items() if text is not None})
    for name in (name for name, text in texts.items() if text is None):
        (folder / name).unlink(missing_ok=True)


def refuse_input(folder: Path, inputs: Sequence[Path]) -> None:
    """Refuse to write results into what is read.

    Raises:
        OutputError: The folder is one of the inputs.
    """
    for source in inputs:
        if folder.resolve() == source.resolve():
            raise OutputError(f"{folder} is what the command reads, and stays as it is. Choose another --output.")


def make_folder(folder: Path) -> None:
    """Create a folder and those above it, and see that files can be written to it before any work is done.

    Raises:
        OutputError: It cannot be created or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise unwritable(folder, error.strerror or str(error)) from None


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Lock a folder against other processes; the system lets go of it when this one ends, however it ends."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(
                f"Another robolaser command is writing into {folder}. Wait for its end, or choose another folder."
            ) from None
        yield
    finally:
        os.close(handle)


def _refuse_what_is_not_its_own(path: Path, owner: str | None, command: str) -> None:
    if owner == command and path.is_file() and not path.is_symlink():
        return
    whose = f"a result of robolaser {owner}" if owner not in (None, command) else "not its own earlier result"
    raise OutputError(
        f"robolaser {command} would write {path}, but what is there is {whose}; it stays as it is, with --force too."
        " Choose another --output, or move the file away."
    )


def _manifest(folder: Path) -> dict[str, str]:
    """The command that wrote each file; a manifest that cannot be read owns nothing."""
    try:
        files = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}
    if not isinstance(files, dict):
        return {}
    return {name: owner for name, owner in files.items() if isinstance(owner, str)}


def _note(folder: Path, owners: Mapping[str, str]) -> None:
    if owners:
        text = json.dumps({"format": FORMAT, "files": dict(sorted(owners.items()))}, indent=1)
        write_text(folder / MANIFEST, text + "\n")
    else:
        (folder / MANIFEST).unlink(missing_ok=True)
