"""CSV tables: columns of checked numbers and texts."""

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import TABLE_BYTES, opened
from robolaser.errors import DataError, near, unreadable

BLOCK_ROWS = 2_000  # taken apart at a time: memory holds the columns of a table, and never all of its cells
BLOCK_LETTERS = 200_000  # the same, where rows are lines


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


def read_table(path: Path, numbers: Sequence[str] = ()) -> CsvTable:
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
    for columns, starts in _blocks(path):
        if not header:
            header = [cells[0].strip() for cells in columns]
            _check_header(path.name, header)
            texts = [[] for _ in header]
            known = {name: [np.empty(0)] for name in header if name in numbers}
            continue
        for name, column, cells in zip(header, texts, columns, strict=True):
            if name in known:
                known[name].append(_numbers(path.name, name, cells, starts))
            else:
                column.extend(map(bare.__getitem__, cells))
        lines += starts
    if not header:
        raise DataError(f"{path.name} is empty: its first row must name the columns.", file=path.name, row=1)
    found = {name: tuple(column) for name, column in zip(header, texts, strict=True) if name not in known}
    return CsvTable(
        path.name, header, found, tuple(lines), {name: np.concatenate(parts) for name, parts in known.items()}
    )


def _blocks(path: Path) -> Iterator[tuple[Sequence[Sequence[str]], Sequence[int]]]:
    """The header, then some rows at a time that are not blank: their cells by column, and the line each starts at."""
    line = width = 0
    with opened(path, TABLE_BYTES, text=True, newline="") as file:
        text = file.readline()
        while columns := _columns_of_lines(text, width):
            starts = range(line + 1, line + 1 + len(columns[0]))
            line, width = starts[-1], len(columns)
            yield columns, starts
            text = file.read(BLOCK_LETTERS) + file.readline()
        for rows, starts_of_rows in _rows(path, chain(io.StringIO(text, newline=""), file), line, width):
            yield list(zip(*rows, strict=True)), starts_of_rows


def _columns_of_lines(text: str, width: int) -> list[list[str]] | None:
    """Cells by column where each line is a row, in a fifth of the time; None where the text asks for a closer look.

    Args:
        text: Whole lines.
        width: Cells of each row; 0 before the header is known.
    """
    text = text.replace("\r\n", "\n").removesuffix("\n")
    if not text or '"' in text or "\r" in text:
        return None
    cells = [*text.replace("\n", ",\n,").split(","), "\n"]
    width = width or cells.index("\n")
    rows = text.count("\n") + 1
    if len(cells) != rows * (width + 1) or cells[width :: width + 1].count("\n") < rows:
        return None
    columns = [cells[j :: width + 1] for j in range(width)]
    return columns if all(map(str.strip, columns[0])) else None


def _rows(path: Path, text: Iterable[str], line: int, width: int) -> Iterator[tuple[list[list[str]], list[int]]]:
    """Rows that are not blank, some at a time, and the line at which each starts; a header comes alone.

    Args:
        path: For messages.
        text: Lines that have not been read yet.
        line: The last line that has.
        width: Cells of each row; 0 where the header has not been read.
    """
    rows: list[list[str]] = []
    lines: list[int] = []
    before = line
    reader = csv.reader(text, strict=True)
    try:
        for row in reader:
            if row and (row[0].strip() or any(map(str.strip, row))):
                if len(row) != (width or len(row)):
                    raise DataError(
                        f"{path.name}, row {line + 1}: {len(row)} cells, but the header names {width} columns.",
                        file=path.name,
                        row=line + 1,
                    )
                rows.append(row)
                lines.append(line + 1)
                if len(rows) == BLOCK_ROWS or not width:
                    yield rows, lines
                    rows, lines, width = [], [], len(row)
            line = before + reader.line_num
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


def table_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A CSV file's text; floats keep every digit that counts."""
    lines: list[str] = []
    writer = csv.writer(SimpleNamespace(write=lines.append))  # ends rows with both signs, and quotes cells with either
    writer.writerow(header)
    for row in rows:
        writer.writerow([f"{float(cell):.12g}" if isinstance(cell, float) else cell for cell in row])
    return "".join(line.removesuffix("\r\n") + "\n" for line in lines)


def numbers(cells: Sequence[str]) -> Array | None:
    """Cells of a table as finite numbers, (n,); None where one of them is not."""
    values = np.array([finite(cell) for cell in cells], dtype=np.float64)
    return values if len(values) and np.isfinite(values).all() else None
