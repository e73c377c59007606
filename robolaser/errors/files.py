"""Sentences about files that cannot be read or written, each said in many places."""

from pathlib import Path

from robolaser.errors.types import DataError, OutputError


def unreadable(path: Path, reason: str) -> DataError:
    """The error of a file that is missing or not what it should be."""
    return DataError(f"Cannot read {path}: {reason}.", file=path)


def unwritable(path: Path, reason: str) -> OutputError:
    """The error of a file that the disk or its rights refuse."""
    return OutputError(
        f"Cannot write {path}: {reason}. What was there before is unchanged; make room or choose another folder."
    )


def output_exists(path: Path) -> OutputError:
    """The error of a result that would be overwritten."""
    return OutputError(f"{path} holds a result already. Choose another --output, or overwrite it with --force.")
