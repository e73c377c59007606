"""A folder that a command writes its results to: locked meanwhile, and only its own earlier results are replaced."""

import json
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from robolaser.bounded_reading import read_json
from robolaser.data.atomic_write import Contents, clear_staged, locked, naming, write_text, write_together
from robolaser.errors import DataError, OutputError, output_exists

MANIFEST = ".robolaser.json"  # what commands wrote into a folder: {"format": …, "files": {name: command}}

FORMAT = "robolaser-results/1"


def json_text(contents: Mapping[str, Any]) -> str:
    """A JSON file of a result."""
    return json.dumps(contents, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


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
) -> Iterator[Callable[[Iterable[str]], None]]:
    """Keep a folder for one command while it runs, and note what it leaves there as its own.

    It gives a function that claims further files, whose names the command comes to know later.

    Args:
        folder: Created if it does not exist.
        command: The command's name.
        files: Names of all that it may write, those in folders below as images/p001.png.
        state: Names of what it leaves when it is stopped, to be gone on with; the command looks after those itself.
        inputs: Data sets, other folders and files that it reads.
        over: Commands whose results it may replace as if they were its own.
        force: Replace earlier results.

    Raises:
        OutputError: The folder or one of the files is an input or in one, the folder is not writable, is written to
            by another process, or holds a file of one of these names that this command did not write, or its earlier
            result without `force`.
    """
    _refuse_input(folder, files, inputs)
    with _made(folder), locked(folder) as free:
        if not free:
            raise OutputError(
                f"Another robolaser command is writing into {folder}. Wait for its end, or choose another folder."
            )
        known, own = _manifest(folder), dict[str, str]()
        cleared = set[Path]()

        def claim(names: Iterable[str]) -> None:
            new = dict.fromkeys(names, command)
            homes = {folder, *((folder / name).parent for name in new)} - cleared
            for home in homes:
                clear_staged(home)
            cleared.update(homes)
            for name in new:
                if name not in own and os.path.lexists(folder / name):
                    _refuse_what_is_not_its_own(folder / name, known.get(name), (command, *over))
                    if not (force or name in state):
                        raise output_exists(folder / name)
            _note(folder, known | own | new)
            own.update(new)

        claim((*files, *state))
        try:
            yield claim
        finally:
            left = {name: owner for name, owner in (known | own).items() if (folder / name).exists()}
            with suppress(OutputError):  # on a full disk the manifest goes on to name what was to be written
                _note(folder, left)


def write_results(folder: Path, contents: Mapping[str, str | Contents | None]) -> None:
    """Write files by their names in the place of an earlier result; what is None this time goes, if that left it.

    A full disk leaves the earlier result; a kill never leaves files of both. The last file, which may name the others,
    is the first to go and the last to come.

    Raises:
        OutputError: The disk or the rights say no.
    """
    there = {name: file for name, file in contents.items() if file is not None}
    files = {name: file.encode() if isinstance(file, str) else file for name, file in there.items()}
    for home in {(folder / name).parent for name in files}:
        make_folder(home)
    write_together(folder, files, list(contents)[::-1])


def _refuse_input(folder: Path, files: Sequence[str], inputs: Sequence[Path]) -> None:
    """Refuse to write results into or over what is read."""
    for written in (folder, *(folder / name for name in files)):
        if any(written.resolve().is_relative_to(source.resolve()) for source in inputs):
            raise OutputError(
                f"{written} is an input of this command or is inside one, and is not changed. Choose another --output."
            )


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """Create a folder that holds something in the end, or is gone again if it was not there before."""
    is_new = not os.path.lexists(folder)
    make_folder(folder)
    try:
        yield
    finally:
        if is_new:
            with suppress(OSError):  # it is not empty
                folder.rmdir()


def make_folder(folder: Path) -> None:
    """Create a folder and those above it, and see that files can be written to it before any work is done.

    Raises:
        OutputError: It cannot be created or written to.
    """
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
        text = json.dumps({"format": FORMAT, "files": dict(sorted(owners.items()))}, indent=1)
        write_text(folder / MANIFEST, text + "\n")
    else:
        (folder / MANIFEST).unlink(missing_ok=True)
