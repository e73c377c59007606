"""Text files with cells between separators, as spreadsheets, controllers and trackers write them."""

import csv
from collections.abc import Sequence
from pathlib import Path

from robolaser.bounded_reading import read_text
from robolaser.data.csv_tables import CsvTable, bad_row
from robolaser.data.importers.importer import ImportOptions
from robolaser.errors import DataError, UsageError, unreadable

NAMES = {"tab": "\t", "space": " ", "comma": ",", "semicolon": ";"}
SEPARATORS = (",", ";", "\t")  # those of which a header has one only, where nothing else is said


def read_delimited(path: Path, options: ImportOptions) -> CsvTable:
    """All cells of a file as texts.

    Raises:
        DataError: The file is not there or not text, lacks the header row, two columns share a name, or a row has more
            or fewer cells than there are columns.
        UsageError: The separator is not said and not plain to see, or makes no sense.
    """
    lines = read_text(path).splitlines()
    first = max(options.header_row, 1)
    if len(lines) < first or not lines[first - 1].strip():
        raise bad_row(path.name, first, "there is no header. State its row with --header-row.")
    separator = _separator(path, lines[first - 1], options)
    rows, starts = _rows(path, lines[first - 1 :], separator, first)
    header = [str(i + 1) for i in range(len(rows[0]))]
    if options.header_row:
        header = rows.pop(0)
        starts.pop(0)
    for name in header:
        if header.count(name) > 1:
            raise DataError(
                f"{path.name} has two columns '{name}'; rename or delete one.", file=path.name, row=first, column=name
            )
    for row, line in zip(rows, starts, strict=True):
        if len(row) != len(header):
            counts = f"{len(row)} cells, but there are {len(header)} columns"
            how = f"Cells are separated by {shown(separator)}; name another with --separator."
            raise bad_row(path.name, line, f"{counts}. {how}")
    columns = {name: tuple(row[i] for row in rows) for i, name in enumerate(header)}
    return CsvTable(path.name, header, columns, tuple(starts), {})


def shown(separator: str) -> str:
    """A separator as a person names it."""
    return next((f"a {name}" for name, sign in NAMES.items() if sign == separator), repr(separator))


def _separator(path: Path, header: str, options: ImportOptions) -> str:
    there = [sign for sign in SEPARATORS if sign in header and sign != options.decimal]
    separator = options.separator
    if separator is None and len(there) != 1:
        found = f"has {' and '.join(map(shown, there))}" if there else "has neither a comma nor a semicolon nor a tab"
        raise UsageError(f"{path.name}: what separates the cells? Its first row {found}. State it with --separator.")
    sign = there[0] if separator is None else NAMES.get(separator, separator)
    if len(sign) != 1 or sign in '"\r\n':
        raise UsageError(f"--separator {separator!r}: expected one character, or {', '.join(NAMES)}.")
    if sign == options.decimal:
        raise UsageError(
            f"--separator and --decimal are both {sign!r}: a separator could not be distinguished from digits."
        )
    return sign


def _rows(path: Path, lines: Sequence[str], separator: str, first: int) -> tuple[list[list[str]], list[int]]:
    """Rows that are not blank, and the line at which each starts."""
    blanks = separator == " "
    reader = csv.reader(
        (f"{line.strip() if blanks else line}\n" for line in lines), delimiter=separator, skipinitialspace=blanks,
        strict=True,
    )  # fmt: skip
    rows, starts, line = [], [], first
    try:
        for row in reader:
            if any(map(str.strip, row)):
                rows.append([cell.strip() for cell in row])
                starts.append(line)
            line = first + reader.line_num
    except csv.Error as error:
        raise unreadable(path, f"line {line}: {error}") from None
    return rows, starts
