"""Files of tables: text with cells between separators, and arrays as NumPy, MATLAB and pandas write them."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import TABLE_BYTES, opened, read_text
from robolaser.data.csv_tables import CsvTable, bad_row, table_of
from robolaser.data.importers.importer import ImportOptions
from robolaser.errors import DataError, RobolaserError, UsageError, unreadable
from robolaser.plugins import extra

NAMES = {"tab": "\t", "space": " ", "comma": ",", "semicolon": ";"}
SEPARATORS = (",", ";", "\t")  # recognised where a header has only one of them


def read_any_table(path: Path, options: ImportOptions) -> CsvTable:
    """All cells of a file as texts, as its suffix says; see `read_delimited` and `read_arrays`."""
    return _array_table(path) if path.suffix.lower() in ARRAY_FILES else read_delimited(path, options)


def read_delimited(path: Path, options: ImportOptions) -> CsvTable:
    """All cells of a file as texts."""
    text = read_text(path)
    if not text.strip():
        raise DataError(f"{path.name} is empty.", file=path.name)
    lines = text.split("\n")
    first = max(options.header_row, 1)
    if len(lines) < first or not lines[first - 1].strip():
        raise bad_row(path.name, first, "there is no header. State its row with --header-row.")
    separator = _separator(path, lines[first - 1], options)
    rows = (f"{line.strip() if separator == ' ' else line}\n" for line in lines[first - 1 :])
    how = f"Cells are separated by {shown(separator)}; name another with --separator."
    return table_of(path, rows, separator=separator, first=first, named=options.header_row > 0, how=how)


def shown(separator: str) -> str:
    """A separator's name in messages."""
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


def read_arrays(path: Path) -> dict[str, Array]:
    """Columns of numbers, or of texts, by name, (n,) each; an array (n, k) is k columns NAME[0], NAME[1] and so on."""
    try:
        with opened(path, TABLE_BYTES) as file:
            found = ARRAY_FILES[path.suffix.lower()](file)
    except RobolaserError:
        raise
    except Exception as error:  # of any type for a damaged file
        raise unreadable(path, " ".join(str(error).split()) or type(error).__name__) from None
    out: dict[str, Array] = {}
    for name, read in found.items():
        values = read.ravel() if read.ndim == 2 and 1 in read.shape else read
        if values.ndim == 1:
            out[name] = values
        elif values.ndim == 2:
            out |= {f"{name}[{i}]": each for i, each in enumerate(values.T)}
    return out


def _array_table(path: Path) -> CsvTable:
    """The columns as a table of texts, numbers to the last bit; NaN is an empty cell."""
    arrays = read_arrays(path)
    lengths = {len(values) for values in arrays.values()}
    if len(lengths) != 1:
        sizes = ", ".join(f"{name} {len(values)}" for name, values in arrays.items())
        raise DataError(f"{path.name}: expected columns of one length, found {sizes or 'none'}.", file=path.name)
    columns = {name: tuple(map(_text, values.tolist())) for name, values in arrays.items()}
    return CsvTable(path.name, columns, tuple(range(1, lengths.pop() + 1)))


def _text(value: Any) -> str:
    return "" if value is None or (isinstance(value, float) and math.isnan(value)) else str(value)


def _npz(file: IO[bytes]) -> dict[str, Array]:
    with np.load(file, allow_pickle=False) as found:
        return {name: found[name] for name in found.files if found[name].dtype.kind in "fiuU"}


def _mat(file: Any) -> dict[str, Array]:
    from scipy.io import loadmat  # noqa: PLC0415 - slow to import

    found: dict[str, Any] = loadmat(file, squeeze_me=True)
    return {name: each for name, each in found.items() if isinstance(each, np.ndarray) and each.dtype.kind in "fiuU"}


def _parquet(file: IO[bytes]) -> dict[str, Array]:
    table = extra("pyarrow.parquet", "Parquet needs pyarrow: pip install pyarrow").read_table(file)
    found: dict[str, Array] = {}
    for name in table.column_names:
        cells = table[name].to_pylist()
        if any(isinstance(cell, str) for cell in cells):
            cells = ["" if cell is None else str(cell) for cell in cells]
        with suppress(TypeError, ValueError):  # dates, images
            values = np.array(cells)
            found[name] = values if values.dtype.kind in "iuU" else values.astype(np.float64)
    return found


ARRAY_FILES: Final[Mapping[str, Callable[[IO[bytes]], dict[str, Array]]]] = {  # by suffix
    ".npz": _npz,
    ".mat": _mat,
    ".parquet": _parquet,
}
TABLE_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", *ARRAY_FILES)
