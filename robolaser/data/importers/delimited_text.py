"""Text files with cells between separators, as spreadsheets, controllers and trackers write them."""

from pathlib import Path

from robolaser.bounded_reading import read_text
from robolaser.data.csv_tables import CsvTable, bad_row, table_of
from robolaser.data.importers.importer import ImportOptions
from robolaser.errors import UsageError

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
    text = (f"{line.strip() if separator == ' ' else line}\n" for line in lines[first - 1 :])
    how = f"Cells are separated by {shown(separator)}; name another with --separator."
    return table_of(path, text, separator=separator, first=first, named=options.header_row > 0, how=how)


def shown(separator: str) -> str:
    """A separator as a person names it."""
    return next((f"a {name}" for name, sign in NAMES.items() if sign == separator), repr(separator))


def _separator(path: Path, header: str, options: ImportOptions) -> str:
    there = [sign for sign in SEPARATORS if sign in header and sign != options.decimal]
    separator = options.separator
    if separator is None and len(there) != 1:
        none = " nor ".join(shown(sign) for sign in SEPARATORS if sign != options.decimal)
        found = f"has {' and '.join(map(shown, there))}" if there else f"has neither {none}"
        raise UsageError(f"{path.name}: what separates the cells? Its first row {found}. State it with --separator.")
    sign = there[0] if separator is None else NAMES.get(separator, separator)
    if len(sign) != 1 or sign in '"\r\n':
        raise UsageError(f"--separator {separator!r}: expected one character, or {', '.join(NAMES)}.")
    if sign == options.decimal:
        raise UsageError(
            f"--separator and --decimal are both {sign!r}: a separator could not be distinguished from digits."
        )
    return sign
