"""Tables as text: joint readings or flange poses, and the points measured in each pose."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.csv_tables import Table, bad_cell, finite
from robolaser.data.dataset import Dataset, Points
from robolaser.data.importers.column_choice import (
    EULER,
    POINTS,
    POSES,
    QUATERNION,
    ROTATION_VECTOR,
    TEXT,
    Chosen,
    Quantities,
    choose,
    point_quantities,
    pose_quantities,
)
from robolaser.data.importers.delimited_text import read_delimited
from robolaser.data.importers.importer import Imported, Importer, ImportOptions, Reading
from robolaser.data.importers.orientation import turned_by, with_quaternions
from robolaser.data.importers.units import ANGLE, Units
from robolaser.data.point_table import points_of
from robolaser.data.pose_table import poses_of
from robolaser.data.sensor_format import sensor_format, sensor_kinds
from robolaser.errors import DataError, UsageError, near

SUFFIXES = (".csv", ".tsv", ".txt", ".dat")


@final
class Tables(Importer):
    """One table whose rows have a pose and a point each, or one of poses and one of points."""

    name: ClassVar[str] = "csv"
    title: ClassVar[str] = "tables as text: joint readings or flange poses, and measured points"

    def recognises(self, path: Path) -> bool:
        """By its suffix."""
        return path.suffix.lower() in SUFFIXES and not path.is_dir()

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read one table, or one of poses and then one of points."""
        if len(paths) > 2:
            raise UsageError(f"{len(paths)} tables: expected one, or one of poses and then one of points.")
        if options.sensor not in sensor_kinds():
            raise UsageError(f"--sensor {options.sensor}: no such sensor.{near(options.sensor, sensor_kinds())}")
        declared = sensor_format(options.sensor)
        if declared.required or declared.options:
            raise UsageError(
                f"--sensor {options.sensor}: dataset.toml has to state more of a {declared.title} than a table holds."
                " Write the data set by hand."
            )
        poses_file, points_file = (read_delimited(path, options) for path in (paths[0], paths[-1]))
        if len(paths) == 1:
            points_file = poses_file
        choice = choose(poses_file, points_file, options, declared)
        poses = _Columns(POSES, poses_file, choice.poses, pose_quantities(options), options)
        points = _Columns(POINTS, points_file, choice.points, point_quantities(declared), options)
        one_file = poses_file is points_file
        pose_table = poses.table(number_poses=one_file)
        if one_file:
            pose_table = _each_once(pose_table, choice.poses)
        pose_table = with_quaternions(pose_table, options.euler)
        read, warnings = poses_of(pose_table, Path(), options.robot)
        dataset = Dataset(
            options.name,
            read,
            Points(np.empty(0, dtype=np.int64), ()),
            kind=declared.kind,
            robot=options.robot,
            path_known=options.path_known,
            source=", ".join(path.name for path in paths),
            warnings=tuple(warnings),
        )
        dataset = replace(dataset, points=points_of(points.table(number_poses=one_file), dataset))
        readings = (columns.readings(number_poses=one_file) for columns in (poses, points))
        return Imported(dataset, tuple(chain(*readings)), choice.left_out)


@final
@dataclass(frozen=True)
class _Columns:
    """The columns of one table of the data set, and how they are read from a file."""

    name: str
    file: Table
    chosen: Chosen
    quantities: Quantities
    options: ImportOptions

    def table(self, *, number_poses: bool) -> Table:
        """The columns by their names in the data set, numbers in SI units."""
        units = Units.of(self.options.units)
        texts: dict[str, tuple[str, ...]] = {}
        known: dict[str, Array] = {}
        for column, source in self.chosen.items():
            quantity = self.quantities.get(column, TEXT)
            if quantity is TEXT:
                texts[column] = self._texts(column, source)
            else:
                known[column] = units.factor(quantity, source) * self._numbers(source)
        if number_poses and "pose" not in self.chosen:
            texts["pose"] = tuple(map(str, self.file.lines))
        if self.name == POINTS and "point" not in self.chosen:
            texts["point"] = (self.options.point or "",) * len(self.file)
        return Table(self.file.file, [*texts, *known], texts, self.file.lines, known)

    def readings(self, *, number_poses: bool) -> list[Reading]:
        """How each column is read."""
        units, table, file = Units.of(self.options.units), f"{self.name}.csv", self.file.file
        found = []
        for column, source in self.chosen.items():
            quantity = self.quantities.get(column, TEXT)
            unit = "" if quantity is TEXT else units.unit(quantity, source)
            if column not in (*EULER, *ROTATION_VECTOR):
                found.append(Reading(table, column, file, source, f"{unit}/s" if column.startswith("qd_") else unit))
        words, first = turned_by(self.chosen, self.options.euler)
        if words:
            found += [Reading(table, column, file, words, units.unit(ANGLE, first)) for column in QUATERNION]
        if number_poses and "pose" not in self.chosen:
            found.insert(0, Reading(table, "pose", file, "(number of the row)"))
        if self.name == POINTS and "point" not in self.chosen:
            found.append(Reading(table, "point", file, "(--point)"))
        return found

    def _texts(self, column: str, source: str) -> tuple[str, ...]:
        cells = self.file.columns[source]
        if column in self.quantities:
            return cells
        plain = tuple(self._plain(cell) for cell in cells)  # a further column, perhaps of numbers
        return plain if np.isfinite([finite(cell) for cell in plain]).all() else cells

    def _numbers(self, source: str) -> Array:
        cells = self.file.columns[source]
        values = np.array([finite(self._plain(cell)) for cell in cells], dtype=np.float64)
        for i in np.flatnonzero(~np.isfinite(values))[:1]:
            sign = self.options.decimal
            other = "," if sign == "." else "."
            hint = f" with the decimal sign {sign!r} (--decimal says another)" if other in cells[i] else ""
            raise bad_cell(self.file.file, self.file.lines[i], source, cells[i], f"a finite number{hint}")
        return values

    def _plain(self, cell: str) -> str:
        """A cell with a decimal point; one that had a point beside another sign is no number."""
        sign = self.options.decimal
        return cell if sign == "." else f"'{cell}'" if "." in cell else cell.replace(sign, ".")


def _each_once(table: Table, chosen: Chosen) -> Table:
    """The first row of each pose, where several rows are points of one pose.

    Raises:
        DataError: Two rows state different readings of a pose.
    """
    names = table.texts("pose")
    first: dict[str, int] = {}
    for row, name in enumerate(names):
        first.setdefault(name, row)
    if len(first) == len(names):
        return table
    of_row = np.array([first[name] for name in names])
    for column in table.header:
        cells = table.known[column] if column in table.known else np.array(table.columns[column], dtype=np.str_)
        for row in np.flatnonzero(cells != cells[of_row])[:1]:
            source, here, there = chosen.get(column, column), table.lines[row], table.lines[of_row[row]]
            raise DataError(
                f"{table.file}, row {here}, column {source}: pose {names[row]} has another value than in row {there}."
                " Rows of one pose repeat its readings; if the arm moved between them, they are different poses.",
                file=table.file,
                row=here,
                column=source,
            )
    rows = np.array(list(first.values()))
    return Table(
        table.file,
        table.header,
        {name: tuple(cells[i] for i in rows) for name, cells in table.columns.items()},
        [table.lines[i] for i in rows],
        {name: values[rows] for name, values in table.known.items()},
    )
