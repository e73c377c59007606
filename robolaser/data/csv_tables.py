"""CSV tables: columns of checked numbers and texts."""

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.bounded_reading import TABLE_BYTES, opened
from robolaser.errors import DataError, near, unreadable

BLOCK_ROWS = 2_000  # taken apart at a time: memory holds the columns of a table, and never all of its cells


@final
@dataclass(frozen=True)
class CsvTable:
    """A CSV file, column by column."""

    file: str  # its name, for messages
    header: Sequence[str]  # the names of all columns
    columns: Mapping[str, tuple[str, ...]]  # the cells of each column that was read as text
    lines: Sequence[int]  # line of the file at which each row starts, counted from one
    known: Mapping[str, Array]  # the columns that were read as numbers, (rows,) each

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

    def take(self, rows: Ints) -> "CsvTable":
        """Some of the rows, by their numbers."""
        kept = rows.tolist()
        columns = {name: tuple(cells[i] for i in kept) for name, cells in self.columns.items()}
        known = {name: values[rows] for name, values in self.known.items()}
        return replace(self, columns=columns, lines=[self.lines[i] for i in kept], known=known)

    def check_all_differ(self, keys: Sequence[object], what: Callable[[int], str]) -> None:
        """See that no row has the key of one before it.

        Raises:
            DataError: One has; with both rows, and `what` a row is.
        """
        if len(set(keys)) == len(keys):
            return
        first: dict[object, int] = {}
        for row, key in enumerate(keys):
            if (before := first.setdefault(key, row)) < row:
                said = f"{what(row)} was already in row {self.lines[before]}. Delete one of the two."
                raise bad_row(self.file, self.lines[row], said)

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


def bad_row(file: str, line: int, what: str, column: str | None = None) -> DataError:
    """The error of a row, or of its cell in a column."""
    where = f"row {line}" if column is None else f"row {line}, column {column}"
    return DataError(f"{file}, {where}: {what}", file=file, row=line, column=column)


def bad_cell(file: str, line: int, column: str, cell: str, expected: str) -> DataError:
    """The error of a cell that holds something else than it should."""
    return bad_row(file, line, f"{repr(cell) if cell else 'empty'}, expected {expected}.", column)


def read_table(path: Path, numbers: Sequence[str] = ()) -> CsvTable:
    """Read a CSV file with a header (RFC 4180; a BOM, CRLF and blank lines are fine).

    Args:
        path: The file.
        numbers: Columns that hold finite numbers, where they are there at all.

    Raises:
        DataError: The file is not there or not text, it has no header, two columns share a name, a row has more or
            fewer cells than the header, or a cell is no number.
    """
    rows = _rows(path)
    _, names = next(rows, (1, []))
    header = [name.strip() for name in names]
    if not header:
        raise DataError(f"{path.name} is empty: its first row must name the columns.", file=path.name, row=1)
    _check_header(path.name, header)
    texts: list[list[str]] = [[] for _ in header]
    known = {name: [np.empty(0)] for name in header if name in numbers}
    lines: list[int] = []
    known_texts: dict[str, str] = {}  # equal ones are kept once
    while block := list(islice(rows, BLOCK_ROWS)):
        starts = [line for line, _ in block]
        for name, column, cells in zip(header, texts, zip(*(row for _, row in block), strict=True), strict=True):
            if name in known:
                known[name].append(_numbers(path.name, name, cells, starts))
            else:
                column.extend(known_texts.setdefault(cell, cell) for cell in map(str.strip, cells))
        lines += starts
    found = {name: tuple(column) for name, column in zip(header, texts, strict=True) if name not in known}
    return CsvTable(
        path.name, header, found, tuple(lines), {name: np.concatenate(parts) for name, parts in known.items()}
    )


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Rows that are not blank, all as long as the first, and the line at which each starts."""
    line = width = 0
    with opened(path, TABLE_BYTES, text=True, newline="") as file:
        reader = csv.reader(file, strict=True)
        try:
            for row in reader:
                if row and (row[0].strip() or any(map(str.strip, row))):
                    width = width or len(row)
                    if len(row) != width:
                        said = f"{len(row)} cells, but the header names {width} columns."
                        raise bad_row(path.name, line + 1, said)
                    yield line + 1, row
                line = reader.line_num
        except csv.Error as error:
            raise unreadable(path, f"line {line + 1}: {error}") from None


def _check_header(file: str, header: Sequence[str]) -> None:
    for name in header:
        if header.count(name) > 1:
            raise DataError(f"{file} has two columns '{name}'; rename or delete one.", file=file, row=1, column=name)


def _numbers(file: str, column: str, cells: Sequence[str], lines: Sequence[int]) -> Array:
    """Cells as finite numbers, (n,)."""
    values = numbers(cells)
    if values is not None:
        return values
    for cell, line in zip(cells, lines, strict=True):
        if not np.isfinite(finite(cell)):
            raise bad_cell(file, line, column, cell.strip(), "a finite number")
    raise AssertionError  # one of them was not


def table_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A CSV file's text; floats keep every digit that counts."""
    lines: list[str] = []
    writer = csv.writer(SimpleNamespace(write=lines.append))  # ends rows with both signs, and quotes cells with either
    writer.writerow(header)
    for row in rows:
        writer.writerow([f"{float(cell):.12g}" if isinstance(cell, float) else cell for cell in row])
    return "".join(line.removesuffix("\r\n") + "\n" for line in lines)


def numbers(cells: Sequence[str]) -> Array | None:
    """Cells of a table as finite numbers, (n,), as `finite` reads them; None where one of them is not."""
    whole = "".join(cells)
    if "_" in whole or not whole.isascii():
        return None
    try:
        values = np.fromiter(map(float, cells), np.float64, len(cells))
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None
