"""Trajectories in TUM's format: lines of time, place and quaternion."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from robolaser.bounded_reading import read_text
from robolaser.data.csv_tables import CsvTable, bad_row, finite
from robolaser.data.dataset import Dataset, Points
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.logs_by_time import CLOCKS, joined_by_time
from robolaser.data.importers.time_matching import TOLERANCE
from robolaser.data.importers.yaml_file import peek
from robolaser.data.pose_table import FLANGE_COLUMNS, check_quaternions, poses_of
from robolaser.errors import DataError, UsageError

COLUMNS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
SUFFIXES = (".tum", ".txt")
BODY = "body"


@final
class Tum(Importer):
    """The flange's trajectory and then that of a body on it as a tracker saw it.

    The body's poses are kept, each with the flange's pose at its time, between the two readings around it.
    """

    name: ClassVar[str] = "tum"
    title: ClassVar[str] = "TUM trajectories (timestamp tx ty tz qx qy qz qw): the flange's, then a tracked body's"
    further: ClassVar[tuple[str, ...]] = (TOLERANCE, CLOCKS)
    takes: ClassVar[tuple[str, ...]] = ("point",)

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
        (flange, *_), (body, *_) = tables = [_read_tum(path) for path in paths]
        repeated = tuple(
            f"{table.file}: {count} rows, whose times repeat the row before" for table, count in tables if count
        )
        numbers = tuple(str(i) for i in range(1, len(flange) + 1))
        poses, _ = poses_of(flange.beside({"pose": numbers}), Path(), None)
        log = Dataset(
            options.name,
            poses,
            Points(np.empty(0, dtype=np.int64), ()),
            kind="pose",
            path_known=options.path_known,
            source=", ".join(path.name for path in paths),
        )
        seen = body.beside({"point": (options.point or BODY,) * len(body)})
        dataset, clock, warnings, left_out = joined_by_time(log, seen, options.further, arm=flange.file, what="pose")
        numbered, at = "(number of the pose)", f"{flange.file}, at the times of {body.file}"
        point = "(--point)" if options.point else "(a name)"
        read_from = {
            "poses.csv": {"pose": numbered, "time_s": f"{body.file}{clock}", "": at},
            "points.csv": {"pose": numbered, "point": point, "": body.file},
        }
        return Imported(replace(dataset, warnings=warnings), read_from, (*repeated, *left_out))


def _read_tum(path: Path) -> tuple[CsvTable, int]:
    """A trajectory's times and flange columns, and how many lines were left out that repeat the time before.

    Raises:
        DataError: A line is not eight finite numbers, a quaternion's length is not one, or times are not in order.
    """
    rows, lines = [], []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        cells = [finite(cell) for cell in _cells(line)]
        if not cells:
            continue
        if len(cells) != len(COLUMNS) or not np.isfinite(cells).all():
            raise bad_row(path.name, number, f"expected eight numbers: {' '.join(COLUMNS)}.")
        rows.append(cells)
        lines.append(number)
    if not rows:
        raise DataError(f"{path.name} has no line of numbers: {' '.join(COLUMNS)}.", file=path.name)
    values = np.array(rows)
    for i in np.flatnonzero(np.diff(values[:, 0]) < 0)[:1]:
        raise DataError(
            f"{path.name}, row {lines[i + 1]}: its time is before that of the row before.",
            file=path.name,
            row=lines[i + 1],
            column=COLUMNS[0],
        )
    table = CsvTable(path.name, dict(zip(("time_s", *FLANGE_COLUMNS), values.T, strict=True)), lines)
    check_quaternions(table, values[:, 4:])
    new = np.flatnonzero(np.diff(values[:, 0], prepend=-np.inf) > 0)
    return table.take(new), len(table) - len(new)


def _cells(line: str) -> list[str]:
    return line.split("#", maxsplit=1)[0].replace(",", " ").split()
