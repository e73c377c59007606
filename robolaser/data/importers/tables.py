"""Tables as text: joint readings or flange poses, and the points measured in each pose."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from robolaser.data.csv_tables import CsvTable
from robolaser.data.dataset import Dataset, Points
from robolaser.data.importers.column_choice import POINTS, POSES, Chosen, choose, point_quantities, pose_quantities
from robolaser.data.importers.column_reader import ColumnReader
from robolaser.data.importers.delimited_text import read_delimited
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of, seen_by_tags
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.orientation import with_quaternions
from robolaser.data.point_table import points_of
from robolaser.data.pose_table import poses_of
from robolaser.data.sensor_format import sensor_format, sensor_kinds
from robolaser.errors import DataError, UsageError, near

SUFFIXES = (".csv", ".tsv", ".txt", ".dat")
TAGGED = "pose"


@final
class Tables(Importer):
    """One table whose rows have a pose and a point each, or one of poses and one of points."""

    name: ClassVar[str] = "csv"
    title: ClassVar[str] = "tables as text: joint readings or flange poses, and measured points"
    further: ClassVar[tuple[str, ...]] = (MOUNT,)

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
        if MOUNT in options.further and declared.kind != TAGGED:
            raise UsageError(
                f"--set {MOUNT} is only for a camera that sees tags, whose poses are read with --sensor {TAGGED}."
            )
        poses_file, points_file = (read_delimited(path, options) for path in (paths[0], paths[-1]))
        if len(paths) == 1:
            points_file = poses_file
        choice = choose(poses_file, points_file, options, declared)
        poses = ColumnReader(POSES, poses_file, choice.poses, pose_quantities(options), options)
        points = ColumnReader(POINTS, points_file, choice.points, point_quantities(declared), options)
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
        if MOUNT in options.further and mount_of(options, points_file.file) == "flange":
            dataset = seen_by_tags(dataset)
        readings = (columns.readings(number_poses=one_file) for columns in (poses, points))
        return Imported(dataset, tuple(chain(*readings)), choice.left_out)


def _each_once(table: CsvTable, chosen: Chosen) -> CsvTable:
    """The first row of each pose, where several rows are points of one pose."""
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
    return CsvTable(
        table.file,
        table.header,
        {name: tuple(cells[i] for i in rows) for name, cells in table.columns.items()},
        [table.lines[i] for i in rows],
        {name: values[rows] for name, values in table.known.items()},
    )
