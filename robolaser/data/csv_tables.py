"""CSV tables: columns of checked numbers and texts."""

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import chain, islice
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.bounded_reading import TABLE_BYTES, opened
from robolaser.errors import DataError, near, unreadable

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

BLOCK_ROWS = 2_000  # parsed at a time: memory holds the columns of a table, never all of its cells

RowTable = TypeVar("RowTable", bound="DataclassInstance")
Cells = tuple[str, ...] | Array  # of a column: texts, or numbers, (rows,)


@final
@dataclass(frozen=True)
class CsvTable:
    """A CSV file, column by column."""

    file: str  # its name, for messages
    columns: Mapping[str, Cells]  # by name, in the file's order
    lines: tuple[int, ...]  # line of the file at which each row starts, counted from one

    def __len__(self) -> int:
        return len(self.lines)

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def cells(self, column: str) -> tuple[str, ...]:
        """The cells of a required column of texts."""
        cells = self._there(column)
        assert isinstance(cells, tuple)  # columns of numbers are read by `numbers`
        return cells

    def texts(self, column: str) -> tuple[str, ...]:
        """The same, none of them empty."""
        cells = self.cells(column)
        if not all(cells):
            raise bad_cell(self.file, self.lines[cells.index("")], column, "", "some text")
        return cells

    def numbers(self, columns: Sequence[str]) -> Array:
        """Required columns as finite numbers, (rows, columns)."""
        out = np.empty((len(self), len(columns)))
        for j, column in enumerate(columns):
            cells = self._there(column)
            out[:, j] = _numbers(self.file, column, cells, self.lines) if isinstance(cells, tuple) else cells
        return out

    def take(self, rows: Ints) -> "CsvTable":
        """Some of the rows, by their numbers."""
        return rows_of(self, rows)

    def check_all_differ(self, keys: Sequence[object], what: Callable[[int], str]) -> None:
        """Check that no row has the key of an earlier one; for the error, `what` describes a row."""
        first: dict[object, int] = {}
        for row, key in enumerate(keys):
            if (before := first.setdefault(key, row)) < row:
                message = f"{what(row)} was already in row {self.lines[before]}. Delete one of the two."
                raise bad_row(self.file, self.lines[row], message)

    def _there(self, column: str) -> Cells:
        if column not in self.columns:
            raise DataError(
                f"{self.file} has no column '{column}'.{near(column, self.columns)}", file=self.file, column=column
            )
        return self.columns[column]


def rows_of(table: RowTable, rows: Ints) -> RowTable:
    """A table with some rows of every column, by their numbers."""
    chosen = rows.tolist()

    def some(column: Any) -> Any:
        if isinstance(column, Mapping):
            return {name: some(values) for name, values in column.items()}
        if isinstance(column, tuple):
            return tuple(map(column.__getitem__, chosen))
        return column[rows] if isinstance(column, np.ndarray) else column

    return replace(table, **{one.name: some(getattr(table, one.name)) for one in fields(table)})


def finite(cell: str) -> float:
    """A cell as a number; NaN where it is none. Underscores and digits of other scripts are not accepted."""
    try:
        return float(cell) if "_" not in cell and cell.isascii() else np.nan
    except ValueError:
        return np.nan


def bad_row(file: str, line: int, what: str, column: str | None = None) -> DataError:
    """The error of a row, or of its cell in a column."""
    where = f"row {line}" if column is None else f"row {line}, column {column}"
    return DataError(f"{file}, {where}: {what}", file=file, row=line, column=column)


def bad_cell(file: str, line: int, column: str, cell: str, expected: str) -> DataError:
    """The error of a cell with a wrong value."""
    return bad_row(file, line, f"{repr(cell) if cell else 'empty'}, expected {expected}.", column)


def read_table(path: Path, numbers: Sequence[str] = ()) -> CsvTable:
    """Read a CSV file with a header (RFC 4180; a BOM, CRLF and blank lines are fine).

    The named columns, where they exist, must be of finite numbers. Names must differ, and all rows be of one length.
    """
    with opened(path, TABLE_BYTES, text=True, newline="") as file:
        return table_of(path, file, numbers)


def table_of(
    path: Path,
    text: Iterable[str],
    numbers: Sequence[str] = (),
    *,
    separator: str = ",",
    first: int = 1,
    named: bool = True,
    how: str = "",
) -> CsvTable:
    """Lines as a table.

    Args:
        path: Their file.
        text: Each with its end.
        numbers: Columns of finite numbers, where they exist.
        separator: Of cells.
        first: The text's first line in the file.
        named: Whether the first row names the columns; else they are called 1, 2, 3 …
        how: How cells are separated, for messages, where this is ambiguous.
    """
    rows = _rows(path, text, separator, first, how)
    line, names = next(rows, (first, []))
    header = [name.strip() if named else str(number) for number, name in enumerate(names, 1)]
    if not header:
        raise DataError(f"{path.name} is empty: its first row must name the columns.", file=path.name, row=line)
    if not how and separator == "," and len(header) == 1 and (other := set(header[0]) & {";", "\t"}):
        expected = "expected commas, and points in numbers. `robolaser import` reads other tables."
        raise bad_row(path.name, line, f"the columns are separated by {min(other)!r}, {expected}")
    for name in header:
        if header.count(name) > 1:
            message = f"{path.name} has two columns '{name}'; rename or delete one."
            raise DataError(message, file=path.name, row=line, column=name)
    rows = rows if named else chain([(line, names)], rows)
    texts: dict[str, list[str]] = {name: [] for name in header if name not in numbers}
    known = {name: [np.empty(0)] for name in header if name in numbers}
    lines: list[int] = []
    known_texts: dict[str, str] = {}  # equal ones are kept once
    while block := list(islice(rows, BLOCK_ROWS)):
        starts = [line for line, _ in block]
        for name, cells in zip(header, zip(*(row for _, row in block), strict=True), strict=True):
            if name in known:
                known[name].append(_numbers(path.name, name, cells, starts))
            else:
                texts[name].extend(known_texts.setdefault(cell, cell) for cell in map(str.strip, cells))
        lines += starts
    columns = {name: np.concatenate(known[name]) if name in known else tuple(texts[name]) for name in header}
    return CsvTable(path.name, columns, tuple(lines))


def _rows(path: Path, text: Iterable[str], separator: str, first: int, how: str) -> Iterator[tuple[int, list[str]]]:
    """Rows that are not blank, all as long as the first, and the line at which each starts."""
    reader = csv.reader(text, delimiter=separator, skipinitialspace=separator == " ", strict=True)
    line, width = first, 0
    try:
        for row in reader:
            if row and (row[0].strip() or any(map(str.strip, row))):
                width = width or len(row)
                if len(row) != width:
                    expected = f"there are {width} columns. {how}" if how else f"the header names {width} columns."
                    raise bad_row(path.name, line, f"{len(row)} cells, but {expected}")
                yield line, row
            line = first + reader.line_num
    except csv.Error as error:
        raise unreadable(path, f"line {line}: {error}") from None


def _numbers(file: str, column: str, cells: Sequence[str], lines: Sequence[int]) -> Array:
    """Cells as finite numbers, (n,)."""
    values = numbers(cells)
    if values is None:
        row = next(row for row, cell in enumerate(cells) if not np.isfinite(finite(cell)))
        raise bad_cell(file, lines[row], column, cells[row].strip(), "a finite number")
    return values


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
