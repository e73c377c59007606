"""Tables whose rows are poses: several files side by side, several points in a row, points that were not measured."""

import re
from collections.abc import Collection, Mapping, Sequence
from itertools import chain, pairwise
from typing import Final

import numpy as np

from robolaser.data.csv_tables import CsvTable
from robolaser.data.sensor_format import XYZ
from robolaser.errors import DataError

AXIS: Final = re.compile(
    r"^(?P<point>.+?)[ _.:/-]*(?P<axis>[xyz])(?:[ _]*[\[(]?(?:mm|cm|m|in|ft)[\])]?)?$", re.IGNORECASE
)
"""The name of a point, and an axis with or without a unit behind it: `R1 X`, `SMR_2.y_mm`, `T3 z [mm]`."""
LOST: Final = ("", "nan", "-", "--", "n/a", "none", "null", "#n/a")
"""What cells hold where a beam was lost, in small letters."""


def beside(tables: Sequence[CsvTable]) -> CsvTable:
    """Several tables as one, row by row; a column is named FILE.COLUMN where its name alone is not unique.

    Raises:
        DataError: They have different numbers of rows.
    """
    first = tables[0]
    for table in tables[1:]:
        if len(table) != len(first):
            raise DataError(
                f"{table.file} has {len(table)} rows, but {first.file} has {len(first)}. Tables that are read side by"
                " side have a row for each pose. Otherwise give one table of poses and one of points, whose column pose"
                " says in which pose each was measured (--column pose=NAME).",
                file=table.file,
            )
    names = [name for table in tables for name in table.columns]
    columns = {
        name if names.count(name) == 1 else f"{table.file.rpartition('.')[0]}.{name}": cells
        for table in tables
        for name, cells in table.columns.items()
    }
    return CsvTable(", ".join(table.file for table in tables), columns, first.lines)


def with_axes(table: CsvTable) -> CsvTable:
    """A table of three columns without a header, read as x, y and z of a point that the file's name names."""
    if list(table.columns) != ["1", "2", "3"]:
        return table
    point = table.file.rpartition(".")[0]
    names = [f"{point}.{axis}" for axis in "xyz"]
    columns = dict(zip(names, table.columns.values(), strict=True))
    return CsvTable(table.file, columns, table.lines)


def points_side_by_side(table: CsvTable, taken: Collection[str]) -> dict[str, tuple[str, str, str]]:
    """The points whose x, y and z are columns of a table, in their order, with these three columns.

    Args:
        table: Has a row for each pose.
        taken: Columns that are known to be something else.
    """
    found: dict[str, dict[str, str]] = {}
    for name in table.columns:
        if name not in taken and (match := AXIS.match(name)):
            found.setdefault(match["point"], {})[match["axis"].lower()] = name
    return {point: (own["x"], own["y"], own["z"]) for point, own in found.items() if len(own) == len(XYZ)}


def a_row_for_each(table: CsvTable, points: Mapping[str, tuple[str, str, str]]) -> CsvTable:
    """The same with a row for each of some points: columns point, x_m, y_m and z_m in the place of theirs."""
    used = set(chain.from_iterable(points.values()))
    rows, n = len(table), len(points)
    columns = {
        name: tuple(chain.from_iterable((cell,) * n for cell in table.cells(name)))
        for name in table.columns
        if name not in used
    }
    columns["point"] = tuple(points) * rows
    for i, column in enumerate(XYZ):
        cells = (table.cells(own[i]) for own in points.values())
        columns[column] = tuple(chain.from_iterable(zip(*cells, strict=True)))
    return CsvTable(table.file, columns, tuple(np.repeat(np.array(table.lines), n).tolist()))


def without_lost(table: CsvTable, columns: Sequence[str]) -> tuple[CsvTable, tuple[str, ...]]:
    """The rows whose points were measured, and what to say of those that were not."""
    lost = np.zeros(len(table), dtype=bool)
    for column in columns:
        lost |= np.fromiter((cell.lower() in LOST for cell in table.cells(column)), bool, len(table))
    if not lost.any() or lost.all():
        return table, ()
    what = f"{table.file}: {lost.sum()} of {len(table)} points, which were not measured (empty cells)"
    return table.take(np.flatnonzero(~lost)), (what,)


def without_repeated_times(table: CsvTable, column: str) -> tuple[CsvTable, tuple[str, ...]]:
    """Of a table with a pose in each row those that do not repeat the time before, and what to say of the others."""
    if column not in table or "pose" in table:
        return table, ()
    cells = table.cells(column)
    again = np.array([False, *(after == before for before, after in pairwise(cells))])
    alike = [own for name, own in table.columns.items() if name != column]
    if not again.any() or any(own[i] == own[i - 1] for own in alike for i in np.flatnonzero(again)[:1]):
        return table, ()  # rows of one pose
    said = f"{table.file}: {again.sum()} rows, whose times repeat the row before"
    return table.take(np.flatnonzero(~again)), (said,)


def joint_columns(table: CsvTable, joints: Sequence[str]) -> dict[str, str]:
    """The columns with the readings of joints, by `q_JOINT`, where they are called otherwise; else none.

    By the names of the joints, or A1 … An, J1 … Jn, joint_1 … and the like.
    """
    readings = [f"q_{joint}" for joint in joints]
    if all(joint in table for joint in joints):
        return dict(zip(readings, joints, strict=True))
    for letters in ("a", "j", "q", "axis", "joint"):
        pattern = re.compile(rf"^{letters}[ _.]?(\d+)(?:[ _]*[\[(]?(?:deg|rad|°)[\])]?)?$", re.IGNORECASE)
        found = {int(m[1]): name for name in table.columns if (m := pattern.match(name))}
        start = 0 if 0 in found else 1
        if set(found) == set(range(start, start + len(joints))):
            return {reading: found[start + i] for i, reading in enumerate(readings)}
    return {}
