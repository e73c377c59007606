"""Trajectories in TUM's format: lines of time, position and quaternion."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import final

import numpy as np

from robolaser.bounded_reading import read_text
from robolaser.data.csv_tables import CsvTable, bad_row, finite, table_of
from robolaser.data.data_tables import FLANGE_COLUMNS
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.tables import import_tables
from robolaser.data.importers.time_matching import CLOCKS, TOLERANCE
from robolaser.data.importers.yaml_file import peek
from robolaser.errors import DataError, UsageError

COLUMNS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
EIGHT = f"expected eight numbers: {' '.join(COLUMNS)}."
SUFFIXES = (".tum", ".txt")
BODY = "body"


@final
class Tum(Importer):
    """The flange's trajectory and then a tracker's of a body on it: two tables, joined by their times."""

    name = "tum"
    title = "TUM trajectories (timestamp tx ty tz qx qy qz qw): the flange's, then a tracked body's"
    further = (TOLERANCE, CLOCKS)
    takes = ("point",)

    def recognises(self, path: Path) -> bool:
        """By its suffix and its first line of numbers."""
        return path.suffix.lower() in SUFFIXES and any(
            len(cells) == len(COLUMNS) and np.isfinite([finite(cell) for cell in cells]).all()
            for cells in islice(filter(None, map(_cells, peek(path).splitlines())), 1)
        )

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read both."""
        if len(paths) != 2:
            raise UsageError(f"Expected two trajectories, the flange's and that of a tracked body, not {len(paths)}.")
        flange, body = map(_table, paths)
        as_tables = replace(options, sensor="pose", units=("m",), point=options.point or BODY)
        return import_tables(flange, body, as_tables, timed=True)


def _table(path: Path) -> CsvTable:
    text = [f"{' '.join(_cells(line))}\n" for line in read_text(path).split("\n")]
    if not any(map(str.strip, text)):
        raise DataError(f"{path.name} has no line of numbers: {' '.join(COLUMNS)}.", file=path.name)
    read = table_of(path, text, separator=" ", named=False, how=EIGHT.capitalize())
    if len(read.columns) != len(COLUMNS):
        raise bad_row(path.name, read.lines[0], EIGHT)
    return replace(read, columns=dict(zip(("time_s", *FLANGE_COLUMNS), read.columns.values(), strict=True)))


def _cells(line: str) -> list[str]:
    return line.split("#", maxsplit=1)[0].replace(",", " ").split()
