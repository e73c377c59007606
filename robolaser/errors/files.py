"""Files, tables and settings that cannot be read or written."""

from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, near


class FileUnreadable(RobolaserError):
    """A file is missing or not what it should be."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"Cannot read {path}: {reason}.")


class FileUnwritable(RobolaserError):
    """The disk or the rights refuse a file."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(
            f"Cannot write {path}: {reason}. What was there before is unchanged; make room or choose another folder."
        )


class OutputExists(RobolaserError):
    """A result would be overwritten."""

    def __init__(self, path: Path) -> None:
        super().__init__(f"{path} holds a result already. Choose another --output, or overwrite it with --force.")


class TableEmpty(RobolaserError):
    """A CSV file without a header."""

    def __init__(self, file: str) -> None:
        super().__init__(f"{file} is empty: its first row must name the columns.")


class ColumnMissing(RobolaserError):
    """A CSV file lacks a column."""

    def __init__(self, file: str, column: str, known: Iterable[str]) -> None:
        super().__init__(f"{file} has no column '{column}'.{near(column, known)}")


class ColumnTwice(RobolaserError):
    """Two columns share a name."""

    def __init__(self, file: str, column: str) -> None:
        super().__init__(f"{file} has two columns '{column}'; rename or delete one.")


class RowLength(RobolaserError):
    """A row has more or fewer cells than the header."""

    def __init__(self, file: str, line: int, cells: int, columns: int) -> None:
        super().__init__(f"{file}, row {line}: {cells} cells, but the header names {columns} columns.")


class BadCell(RobolaserError):
    """A cell holds something else than it should."""

    def __init__(self, file: str, line: int, column: str, cell: str, expected: str) -> None:
        shown = f"'{cell}'" if cell else "empty"
        super().__init__(f"{file}, row {line}, column {column}: {shown}, expected {expected}.")


class RowTwice(RobolaserError):
    """Two rows say the same."""

    def __init__(self, file: str, line: int, first: int, what: str) -> None:
        super().__init__(f"{file}, row {line}: {what} was already in row {first}. Delete one of the two.")


class SettingMissing(RobolaserError):
    """A file of settings lacks a value."""

    def __init__(self, key: str, expected: str, file: str = "dataset.toml") -> None:
        super().__init__(f"{file} lacks {key}: expected {expected}.")


class SettingWrong(RobolaserError):
    """A file of settings holds a value of the wrong kind."""

    def __init__(self, key: str, value: object, expected: str, file: str = "dataset.toml") -> None:
        super().__init__(f"{file}, {key}: {value!r}, expected {expected}.")


class FormatUnknown(RobolaserError):
    """A file of another format or a later version."""

    def __init__(self, file: str, found: object, expected: str) -> None:
        super().__init__(f"{file} has format {found!r}, but this program reads '{expected}'.")


class NotToml(RobolaserError):
    """A file of settings cannot be parsed."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path} is not valid TOML: {reason}.")


class NotADataset(RobolaserError):
    """A folder without dataset.toml."""

    def __init__(self, folder: Path) -> None:
        what = "is not there" if not folder.exists() else "has no dataset.toml"
        super().__init__(f"{folder} {what}. A data set is a folder with dataset.toml, poses.csv and points.csv.")


class PathLeaves(RobolaserError):
    """A path in the data set points out of its folder."""

    def __init__(self, where: str, path: str) -> None:
        super().__init__(
            f"{where}: '{path}' leaves the data set's folder. Copy the file into it and name it relatively."
        )


class NotACell(RobolaserError):
    """A folder without cell.toml."""

    def __init__(self, folder: Path) -> None:
        what = "is not there" if not folder.exists() else "has no cell.toml"
        super().__init__(f"{folder} {what}. A cell is a folder with dataset.toml, cell.toml and the robot's URDF.")
