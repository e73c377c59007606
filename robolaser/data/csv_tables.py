"""CSV tables: columns of checked numbers and texts, and files that are written whole or not at all."""

import csv
import io
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import (
    BadCell,
    ColumnMissing,
    ColumnTwice,
    FileUnreadable,
    FileUnwritable,
    RowLength,
    TableEmpty,
)

HEADER_ROWS = 1
CHUNK = 1 << 17  # characters of a table that are taken apart at a time: their cells fit the processor's cache


@final
@dataclass(frozen=True)
class Table:
    """A CSV file as texts, and as numbers where that was all there is to a column.

    Attributes:
        file: Its name, for messages.
        header: The names of all columns.
        columns: The cells of each column.
        lines: Line of the file at which each row starts, counted from one.
        known: Columns that are finite numbers and nothing else, (rows,) each; they have no cells in `columns`.
    """

    file: str
    header: Sequence[str]
    columns: Mapping[str, tuple[str, ...]]
    lines: Sequence[int]
    known: Mapping[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.lines)

    def __contains__(self, column: str) -> bool:
        return column in self.header

    def texts(self, column: str) -> tuple[str, ...]:
        """The cells of a column that must be there, none of them empty."""
        if column not in self.columns:
            raise ColumnMissing(self.file, column, self.header)
        cells = self.columns[column]
        if not all(cells):
            raise BadCell(self.file, self.lines[cells.index("")], column, "", "some text")
        return cells

    def numbers(self, columns: Sequence[str]) -> Array:
        """Columns that must be there, as finite numbers, (rows, columns)."""
        out = np.empty((len(self), len(columns)))
        for j, column in enumerate(columns):
            if column in self.known:
                out[:, j] = self.known[column]
                continue
            if column not in self.columns:
                raise ColumnMissing(self.file, column, self.header)
            out[:, j] = [finite(cell) for cell in self.columns[column]]
            for i in np.flatnonzero(~np.isfinite(out[:, j]))[:1]:
                raise BadCell(self.file, self.lines[i], column, self.columns[column][i], "a finite number")
        return out


def finite(cell: str) -> float:
    """A cell as a number; NaN where it is none. Underscores and other scripts' digits are not taken for numbers."""
    try:
        return float(cell) if "_" not in cell and cell.isascii() else np.nan
    except ValueError:
        return np.nan


def read_text(path: Path) -> str:
    """A text file, its byte order mark taken off.

    Raises:
        FileUnreadable: It is not there, no plain file (a pipe would never end), or not UTF-8.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise FileUnreadable(path, "it is no plain file")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FileUnreadable(path, error.strerror or str(error)) from None
    except UnicodeDecodeError as error:
        raise FileUnreadable(path, f"byte {error.start} is not UTF-8 text") from None


def read_table(path: Path, numbers: Sequence[str] = ()) -> Table:
    """Read a CSV file with a header (RFC 4180; a BOM, CRLF and blank lines are fine).

    Args:
        path: The file.
        numbers: Columns of which nobody will want the texts, where all is well with them.

    Raises:
        FileUnreadable: It is not there or not text.
        TableEmpty: It has no header.
        ColumnTwice: Two columns share a name.
        RowLength: A row has more or fewer cells than the header.
    """
    return _plain_table(path, numbers) or _any_table(path)


def _plain_table(path: Path, numbers: Sequence[str]) -> Table | None:
    """A table with nothing unusual in it, taken apart quickly; None for any other, which needs a closer look."""
    if not path.is_file():
        return None
    texts: dict[str, list[str]] = {}
    known: dict[str, list[Array]] = {}
    bare = _Bare()
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            header = [name.strip() for name in next(csv.reader([file.readline()], strict=True), [])]
            if len(set(header)) < len(header) or not set(header) & set(numbers):
                return None
            texts |= {name: [] for name in header if name not in numbers}
            known |= {name: [np.empty(0)] for name in header if name in numbers}
            text = file.read(CHUNK) + file.readline()
            while text:
                following = file.read(CHUNK) + file.readline()
                columns = _columns(text if following else text.rstrip("\r\n"), len(header))
                for name, cells in zip(header, columns, strict=True):
                    if name in known:
                        known[name].append(_numbers(cells))
                    else:
                        texts[name] += map(bare.__getitem__, cells)
                text = following
    except (OSError, ValueError, csv.Error):
        return None
    found = {name: np.concatenate(parts) for name, parts in known.items()}
    rows = len(next(iter(found.values())))
    lines = range(1 + HEADER_ROWS, 1 + HEADER_ROWS + rows)
    return Table(path.name, header, {name: tuple(cells) for name, cells in texts.items()}, lines, found)


@final
class _Bare(dict[str, str]):
    """Cells without the space around them; equal ones are kept once."""

    def __missing__(self, cell: str) -> str:
        bare = cell.strip()
        self[cell] = found = self.setdefault(bare, bare)
        return found


def _columns(text: str, width: int) -> list[list[str]]:
    """Cells of each column of a piece of a table.

    Raises:
        ValueError: A row is blank, has another length or more than one line.
    """
    text = text.replace("\r\n", "\n").removesuffix("\n")
    rows = text.count("\n") + 1
    cells: list[str]
    if '"' in text:
        cells = [cell for row in csv.reader(io.StringIO(text, newline=""), strict=True) for cell in (*row, "\n")]
    else:
        cells = [*text.replace("\n", ",\n,").split(","), "\n"]
    ends = cells[width :: width + 1]
    if len(cells) != rows * (width + 1) or ends.count("\n") < rows or "\r" in text:
        raise ValueError
    return [cells[j :: width + 1] for j in range(width)]


def _numbers(cells: list[str]) -> Array:
    whole = "".join(cells)
    if "_" in whole or not whole.isascii():  # as in `finite`
        raise ValueError
    values = np.fromiter(map(float, cells), np.float64, len(cells))
    if not np.isfinite(values).all():
        raise ValueError
    return values


def _any_table(path: Path) -> Table:
    reader = csv.reader(io.StringIO(read_text(path), newline=""), strict=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    start = 1
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                rows.append([cell.strip() for cell in row])
                lines.append(start)
            start = reader.line_num + 1
    except csv.Error as error:
        raise FileUnreadable(path, f"line {start}: {error}") from None
    if not rows:
        raise TableEmpty(path.name)
    header = rows[0]
    for name in header:
        if header.count(name) > 1:
            raise ColumnTwice(path.name, name)
    for row, line in zip(rows[HEADER_ROWS:], lines[HEADER_ROWS:], strict=True):
        if len(row) != len(header):
            raise RowLength(path.name, line, len(row), len(header))
    cells = list(zip(*rows[HEADER_ROWS:], strict=True)) or [() for _ in header]
    return Table(path.name, header, dict(zip(header, cells, strict=True)), tuple(lines[HEADER_ROWS:]))


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; floats keep every digit that counts."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([f"{float(cell):.12g}" if isinstance(cell, float) else cell for cell in row])
    write_text(path, text.getvalue())


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all: a full disk or a power cut leaves what was there before.

    Raises:
        FileUnwritable: The disk or the rights say no.
    """
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """As `write_text`, for bytes."""
    write_together({path: data})


def write_together(files: Mapping[Path, bytes]) -> None:
    """Write files that belong together: all, or none where the disk has no room for them.

    Raises:
        FileUnwritable: The disk or the rights say no.
    """
    with ExitStack() as open_files:
        staged = {path: open_files.enter_context(_beside(path)) for path in files}
        for path, file in staged.items():
            with _naming(path):
                file.write(files[path])
                _settle(file)
        for path, file in staged.items():
            with _naming(path):
                os.replace(file.name, path)


@contextmanager
def written_whole(path: Path) -> Iterator[BinaryIO]:
    """Open a file to write to that is there once all is written, and not at all where something goes wrong.

    What was there before stays until then.

    Raises:
        FileUnwritable: The disk or the rights say no.
    """
    with _beside(path) as file, _naming(path):
        yield file
        _settle(file)
        os.replace(file.name, path)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise FileUnwritable(path, error.strerror or str(error)) from None


@contextmanager
def _beside(path: Path) -> Iterator[BinaryIO]:
    """A file under a name of its own beside the one that it may become; gone afterwards unless it was renamed."""
    with _naming(path):
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    with open(name, "wb", opener=lambda *_: descriptor) as file:
        try:
            yield file
        finally:
            Path(name).unlink(missing_ok=True)


def _settle(file: BinaryIO) -> None:
    """See that all is safe on the disk, for everybody to read."""
    file.flush()
    os.fsync(file.fileno())
    os.chmod(file.name, 0o644)
