"""Folders and files that a command writes: usable before any work is done, and never overwritten silently."""

from pathlib import Path

from robolaser.errors import OutputError


def refuse_to_overwrite(file: Path, *, force: bool) -> None:
    """Refuse to overwrite a result, unless that is wanted.

    Raises:
        OutputError: It is there.
    """
    if file.exists() and not force:
        raise OutputError(f"{file} holds a result already. Choose another --output, or overwrite it with --force.")


def make_folder(folder: Path) -> None:
    """Create a folder and those above it, and see that files can be written to it before any work is done.

    Raises:
        OutputError: It cannot be created or written to.
    """
    import tempfile

    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise unwritable(folder, error) from None


def unwritable(path: Path, error: OSError) -> OutputError:
    """The error for a path that the disk or its rights refuse."""
    return OutputError(
        f"Cannot write {path}: {error.strerror or error}. What was there before is unchanged; make room or choose"
        " another folder."
    )
