"""Tables: joint readings or flange poses, and the points measured in each pose, side by side or in own rows."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from pathlib import Path
from typing import Final, final

import numpy as np

from robolaser.data.csv_tables import CsvTable, bad_row
from robolaser.data.data_tables import points_of, poses_of
from robolaser.data.dataset import Dataset
from robolaser.data.importers.column_choice import (
    POINTS,
    POSES,
    choose,
    point_quantities,
    pose_quantities,
    with_quaternions,
)
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of, seen_by_tags
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.table_files import TABLE_SUFFIXES, read_any_table
from robolaser.data.importers.time_matching import CLOCKS, TOLERANCE, joined_by_time
from robolaser.data.sensor_format import XYZ, SensorFormat, sensor_format, sensor_kinds
from robolaser.errors import DataError, UsageError, near

TAGGED = "pose"


@final
class Tables(Importer):
    """A table whose rows have a pose and points; one of poses, one of points, by pose or time; or several, by row."""

    name = "csv"
    title = "tables (text, NPZ, MAT, Parquet): joint readings or flange poses, and measured points"
    further = (MOUNT, TOLERANCE, CLOCKS)

    def recognises(self, path: Path) -> bool:
        """By its suffix."""
        return path.suffix.lower() in TABLE_SUFFIXES and not path.is_dir()

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read one table, one of poses and then one of points, or several with a row for each pose."""
        if options.sensor not in sensor_kinds():
            raise UsageError(f"--sensor {options.sensor}: no such sensor.{near(options.sensor, sensor_kinds())}")
        declared = sensor_format(options.sensor)
        if declared.required or declared.options:
            raise UsageError(
                f"--sensor {options.sensor}: dataset.toml has to state more of a {declared.title} than a table holds."
                " Write the data set by hand."
            )
        if MOUNT in options.further and declared.kind != TAGGED:
            raise UsageError(
                f"--set {MOUNT} is only for a camera that sees tags, whose poses are read with --sensor {TAGGED}."
            )
        timed = bool({TOLERANCE, CLOCKS} & options.further.keys())
        if timed and len(paths) != 2:
            raise UsageError(f"--set {TOLERANCE} and {CLOCKS} are for two files, the arm's log and what was measured.")
        poses_file, points_file, left_out = _read(paths, options, declared, timed=timed)
        imported = import_tables(poses_file, points_file, options, timed=timed)
        if MOUNT in options.further and mount_of(options, points_file.file) == "flange":
            imported = replace(imported, dataset=seen_by_tags(imported.dataset))
        return replace(imported, left_out=(*left_out, *imported.left_out))


def import_tables(poses_file: CsvTable, points_file: CsvTable, options: ImportOptions, *, timed: bool) -> Imported:
    """A table of poses, and one of points, as a data set; in one table of both, poses may repeat.

    If they are timed, a point's pose is determined by its time rather than by its name.
    """
    declared = sensor_format(options.sensor)
    known = {POSES: pose_quantities(options), POINTS: point_quantities(declared, timed=timed)}
    columns, not_read = choose({POSES: poses_file, POINTS: points_file}, known, options)
    poses, points = columns[POSES], columns[POINTS]
    measured, lost = without_lost(points_file, [points.chosen[name] for name in XYZ if name in points.chosen])
    points = replace(points, file=measured)
    one_file = poses_file is points_file
    pose_table, of_poses = poses.read(number_poses=one_file or timed)
    if one_file:
        pose_table = _each_once(pose_table, poses.chosen)
    read, warnings = poses_of(with_quaternions(pose_table, options.euler), Path(), options.robot)
    if options.ordered and read.time_s is not None:
        message = "--ordered is for files without times, but time_s is read from a column. Leave one of them out."
        raise UsageError(message)
    if options.ordered:
        read = replace(read, time_s=np.arange(float(len(read))))
    dataset = Dataset(
        options.name,
        read,
        kind=declared.kind,
        robot=options.robot,
        time_is_order=options.ordered,
        path_known=options.path_known,
        source=", ".join(dict.fromkeys((poses_file.file, points_file.file))),
        warnings=tuple(warnings),
    )
    point_table, of_points = points.read(number_poses=one_file)
    if timed:
        dataset, clock, without = joined_by_time(dataset, point_table, options.further, poses_file.file)
        lost = (*without, *lost)
        of_poses = {name: f"{source}, at the times of {points_file.file}" for name, source in of_poses.items()}
        of_poses["time_s"] = f"{of_points.pop('time_s')}{clock}"
        of_poses["pose"] = of_points["pose"] = "(number of the pose)"
    else:
        dataset = replace(dataset, points=points_of(point_table, dataset))
    return Imported(dataset, {"poses.csv": of_poses, "points.csv": of_points}, (*not_read, *lost))


def _read(
    paths: Sequence[Path], options: ImportOptions, declared: SensorFormat, *, timed: bool
) -> tuple[CsvTable, CsvTable, tuple[str, ...]]:
    """The table of the poses, that of the points, which may be the same, and messages on rows left out."""
    tables = [read_any_table(path, options) for path in paths]
    named = "pose" in options.columns or "points.pose" in options.columns
    if timed or (len(tables) == 2 and (named or "pose" in tables[1])):
        return tables[0], tables[1], ()
    table = beside([with_axes(table) for table in tables]) if len(tables) > 1 else tables[0]
    table, left_out = without_repeated_times(table, options.columns.get("time_s", "time_s"))
    points = _points_in_a_row(table, options, declared)
    if points:
        table = a_row_for_each(table, points)
    return table, table, left_out


def _points_in_a_row(
    table: CsvTable, options: ImportOptions, declared: SensorFormat
) -> dict[str, tuple[str, str, str]]:
    """Points whose x, y and z are columns, where the sensor's rows are positions and no option names their columns."""
    stated = {name.removeprefix(f"{POINTS}.") for name in options.columns if not name.startswith(f"{POSES}.")}
    places = {column for group in declared.columns.values() for column in group} == set(XYZ)
    if not places or options.point is not None or stated & {"point", *XYZ} or "point" in table:
        return {}
    taken = {*pose_quantities(options), *point_quantities(declared), *options.columns.values()}
    found: dict[str, dict[str, str]] = {}
    for name in table.columns:
        if name not in taken and (match := AXIS.match(name)):
            found.setdefault(match["point"], {})[match["axis"].lower()] = name
    return {point: (own["x"], own["y"], own["z"]) for point, own in found.items() if len(own) == len(XYZ)}


def _each_once(table: CsvTable, chosen: Mapping[str, str]) -> CsvTable:
    """The first row of each pose, where several rows are points of one pose."""
    names = table.texts("pose")
    first: dict[str, int] = {}
    for row, name in enumerate(names):
        first.setdefault(name, row)
    if len(first) == len(names):
        return table
    of_row = np.array([first[name] for name in names])
    for column, values in table.columns.items():
        cells = np.asarray(values)
        for row in np.flatnonzero(cells != cells[of_row])[:1]:
            what = f"pose {names[row]} has another value than in row {table.lines[of_row[row]]}."
            why = "Rows of one pose repeat its readings; if the arm moved between them, they are different poses."
            raise bad_row(table.file, table.lines[row], f"{what} {why}", chosen.get(column, column))
    return table.take(np.array(list(first.values())))


AXIS: Final = re.compile(  # the name of a point, and an axis with or without a unit: `R1 X`, `SMR_2.y_mm`, `T3 z [mm]`
    r"^(?P<point>.+?)[ _.:/-]*(?P<axis>[xyz])(?:[ _]*[\[(]?(?:mm|cm|m|in|ft)[\])]?)?$", re.IGNORECASE
)
LOST: Final = ("", "nan", "-", "--", "n/a", "none", "null", "#n/a")  # cells of lost measurements, in lower case


def beside(tables: Sequence[CsvTable]) -> CsvTable:
    """Several tables as one, row by row; a column is named FILE.COLUMN where its name alone is not unique."""
    first = tables[0]
    for table in tables[1:]:
        if len(table) != len(first):
            raise DataError(
                f"{table.file} has {len(table)} rows, but {first.file} has {len(first)}. Tables that are read side by"
                " side have a row for each pose. Otherwise give one table of poses and one of points, whose column pose"
                " names the pose of each (--column pose=NAME).",
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
    columns = dict(zip([f"{point}.{axis}" for axis in "xyz"], table.columns.values(), strict=True))
    return CsvTable(table.file, columns, table.lines)


def a_row_for_each(table: CsvTable, points: Mapping[str, tuple[str, str, str]]) -> CsvTable:
    """The same with a row for each of some points: columns point, x_m, y_m and z_m replace theirs."""
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
    """The rows with measured points, and messages on the others."""
    lost = np.zeros(len(table), dtype=bool)
    for column in columns:
        lost |= np.fromiter((cell.lower() in LOST for cell in table.cells(column)), bool, len(table))
    if not lost.any() or lost.all():
        return table, ()
    what = f"{table.file}: {lost.sum()} of {len(table)} points, which were not measured (empty cells)"
    return table.take(np.flatnonzero(~lost)), (what,)


def without_repeated_times(table: CsvTable, column: str) -> tuple[CsvTable, tuple[str, ...]]:
    """The rows that do not repeat the previous time, in a table with a pose in each row, and messages on the others."""
    if column not in table or "pose" in table:
        return table, ()
    again = np.array([False, *(after == before for before, after in pairwise(table.cells(column)))])
    alike = [own for name, own in table.columns.items() if name != column]
    if not again.any() or any(own[i] == own[i - 1] for own in alike for i in np.flatnonzero(again)[:1]):
        return table, ()  # rows of one pose
    message = f"{table.file}: {again.sum()} rows, whose times repeat the row before"
    return table.take(np.flatnonzero(~again)), (message,)
