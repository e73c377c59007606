"""CSV tables: columns of checked numbers and texts."""

import csv
import io
import stat
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.atomic_write import write_text
from robolaser.errors import DataError, near, unreadable

BLOCK_ROWS = 2_000  # taken apart at a time: memory holds the columns of a table, and never all of its cells


@final
@dataclass(frozen=True)
class Table:
    """A CSV file, column by column.

    Attributes:
        file: Its name, for messages.
        header: The names of all columns.
        columns: The cells of each column that was read as text.
        lines: Line of the file at which each row starts, counted from one.
        known: The columns that were read as numbers, (rows,) each.
    """

    file: str
    header: Sequence[str]
    columns: Mapping[str, tuple[str, ...]]
    lines: Sequence[int]
    known: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.lines)

    def __contains__(self, column: str) -> bool:
        return column in self.header

    def texts(self, column: str) -> tuple[str, ...]:
        """The cells of a column that must be there, none of them empty."""
        cells = self.columns[self._there(column)]
        if not all(cells):
            raise bad_cell(self.file, self.lines[cells.index("")], column, "", "some text")
        return cells

    def numbers(self, columns: Sequence[str]) -> Array:
        """Columns that must be there, as finite numbers, (rows, columns)."""
        out = np.empty((len(self), len(columns)))
        for j, column in enumerate(columns):
            if self._there(column) in self.known:
                out[:, j] = self.known[column]
            else:
                out[:, j] = _numbers(self.file, column, self.columns[column], self.lines)
        return out

    def _there(self, column: str) -> str:
        if column not in self.header:
            raise DataError(
                f"{self.file} has no column '{column}'.{near(column, self.header)}", file=self.file, column=column
            )
        return column


def finite(cell: str) -> float:
    """A cell as a number; NaN where it is none. Underscores and other scripts' digits are not taken for numbers."""
    try:
        return float(cell) if "_" not in cell and cell.isascii() else np.nan
    except ValueError:
        return np.nan


def bad_cell(file: str, line: int, column: str, cell: str, expected: str) -> DataError:
    """The error of a cell that holds something else than it should."""
    shown = repr(cell) if cell else "empty"
    return DataError(
        f"{file}, row {line}, column {column}: {shown}, expected {expected}.", file=file, row=line, column=column
    )


def read_text(path: Path) -> str:
    """A text file, its byte order mark taken off.

    Raises:
        DataError: It is not there, no plain file (a pipe would never end), or not UTF-8.
    """
    with _opened(path) as file:
        return file.read()


@contextmanager
def _opened(path: Path, newline: str | None = None) -> Iterator[TextIO]:
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise unreadable(path, "it is no plain file")
        with path.open(encoding="utf-8-sig", newline=newline) as file:
            yield file
    except OSError as error:
        raise unreadable(path, error.strerror or str(error)) from None
    except UnicodeDecodeError:
        raise unreadable(path, f"byte {_undecodable(path)} is not UTF-8 text") from None


def _undecodable(path: Path) -> int:
    try:
        path.read_bytes().decode()
    except UnicodeDecodeError as error:
        return error.start
    return 0


def read_table(path: Path, numbers: Sequence[str] = ()) -> Table:
    """Read a CSV file with a header (RFC 4180; a BOM, CRLF and blank lines are fine).

    Args:
        path: The file.
        numbers: Columns that hold finite numbers, where they are there at all.

    Raises:
        DataError: The file is not there or not text, it has no header, two columns share a name, a row has more or
            fewer cells than the header, or a cell is no number.
    """
    header: list[str] = []
    texts: list[list[str]] = []
    known: dict[str, list[Array]] = {}
    lines: list[int] = []
    bare = _Bare()
    for rows, starts in _blocks(path):
        if not header:
            header = [name.strip() for name in rows.pop(0)]
            starts.pop(0)
            _check_header(path.name, header)
            texts = [[] for _ in header]
            known = {name: [np.empty(0)] for name in header if name in numbers}
        for row, line in zip(rows, starts, strict=True):
            if len(row) != len(header):
                raise DataError(
                    f"{path.name}, row {line}: {len(row)} cells, but the header names {len(header)} columns.",
                    file=path.name,
                    row=line,
                )
        for name, column, cells in zip(header, texts, zip(*rows, strict=True), strict=False):
            if name in known:
                known[name].append(_numbers(path.name, name, cells, starts))
            else:
                column.extend(map(bare.__getitem__, cells))
        lines += starts
    if not header:
        raise DataError(f"{path.name} is empty: its first row must name the columns.", file=path.name, row=1)
    columns = {name: tuple(column) for name, column in zip(header, texts, strict=True) if name not in known}
    return Table(
        path.name, header, columns, tuple(lines), {name: np.concatenate(parts) for name, parts in known.items()}
    )


def _blocks(path: Path) -> Iterator[tuple[list[list[str]], list[int]]]:
    """Rows that are not blank, some at a time, and the line at which each starts."""
    rows: list[list[str]] = []
    lines: list[int] = []
    line = 0
    with _opened(path, newline="") as file:
        reader = csv.reader(file, strict=True)
        try:
            for row in reader:
                if row and (row[0].strip() or any(map(str.strip, row))):
                    rows.append(row)
                    lines.append(line + 1)
                    if len(rows) == BLOCK_ROWS:
                        yield rows, lines
                        rows, lines = [], []
                line = reader.line_num
        except csv.Error as error:
            raise unreadable(path, f"line {line + 1}: {error}") from None
    if rows:
        yield rows, lines


@final
class _Bare(dict[str, str]):
    """Cells without the space around them; equal ones are kept once."""

    def __missing__(self, cell: str) -> str:
        bare = cell.strip()
        self[cell] = found = self.setdefault(bare, bare)
        return found


def _check_header(file: str, header: Sequence[str]) -> None:
    for name in header:
        if header.count(name) > 1:
            raise DataError(f"{file} has two columns '{name}'; rename or delete one.", file=file, row=1, column=name)


def _numbers(file: str, column: str, cells: Sequence[str], lines: Sequence[int]) -> Array:
    """Cells as finite numbers, (n,)."""
    whole = "".join(cells)
    if "_" not in whole and whole.isascii():
        try:
            values = np.fromiter(map(float, cells), np.float64, len(cells))
        except ValueError:
            values = np.full(len(cells), np.nan)
        if np.isfinite(values).all():
            return values
    for cell, line in zip(cells, lines, strict=True):
        if not np.isfinite(finite(cell)):
            raise bad_cell(file, line, column, cell.strip(), "a finite number")
    raise AssertionError  # one of them was not


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; floats keep every digit that counts."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([f"{float(cell):.12g}" if isinstance(cell, float) else cell for cell in row])
    write_text(path, text.getvalue())
