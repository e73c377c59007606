"""The columns of poses.csv and points.csv in a file, and how they are read."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.csv_tables import Cells, CsvTable, bad_cell, finite
from robolaser.data.dataset import COMMAND
from robolaser.data.importers.importer import NONE, ImportOptions, stated_units, unit_of
from robolaser.data.sensor_format import QUATERNION, XYZ, SensorFormat
from robolaser.errors import DataError, UsageError, near
from robolaser.geometry.rigid_motion import exp_so3, to_quaternion
from robolaser.geometry.units import ANGLE, FACTORS, LENGTH, TIME

POSES: Final = "poses"
POINTS: Final = "points"
EULER = ("euler_1", "euler_2", "euler_3")
ROTATION_VECTOR = ("rotvec_x", "rotvec_y", "rotvec_z")
ORIENTATIONS = (QUATERNION, EULER, ROTATION_VECTOR)  # alternative forms of the flange's orientation
Chosen = Mapping[str, str]  # column of a file by the column of the data set
TEXT: Final = None  # in place of a quantity: the column holds texts

ColumnQuantities = Mapping[str, str | None]


def pose_quantities(options: ImportOptions) -> ColumnQuantities:
    """The columns of poses.csv that can be read, and the quantity of each."""
    readings: dict[str, str | None]
    if options.robot is None:
        angles = dict.fromkeys((*EULER, *ROTATION_VECTOR), ANGLE)
        readings = {**dict.fromkeys(XYZ, LENGTH), **dict.fromkeys(QUATERNION, NONE), **angles}
    else:
        readings = {
            f"{q}_{joint}": LENGTH if slides else ANGLE
            for q in ("q", "qd", COMMAND.rstrip("_"))
            for joint, slides in zip(options.robot.joints, options.robot.prismatic, strict=True)
        }
    return {"pose": TEXT, "time_s": TIME, **readings, "temperature_c": NONE, "payload_kg": NONE}


def point_quantities(declared: SensorFormat, *, timed: bool = False) -> ColumnQuantities:
    """The columns of points.csv that can be read, and the quantity of each; times determine poses if they are timed."""
    columns = [column for group in declared.columns.values() for column in group]
    when: dict[str, str | None] = {"time_s": TIME} if timed else {"pose": TEXT}
    by_suffix = {"m": LENGTH, "rad": ANGLE, "s": TIME}
    measured = {name: by_suffix.get(name.rpartition("_")[2], NONE) for name in columns}
    return {**when, "point": TEXT, "repeat": NONE, **measured}


@final
@dataclass(frozen=True)
class ColumnReader:
    """The columns of one table of the data set, and how they are read from a file."""

    name: str  # of the table: POSES or POINTS
    file: CsvTable
    chosen: Chosen
    quantities: ColumnQuantities
    options: ImportOptions

    def read(self, *, number_poses: bool) -> tuple[CsvTable, dict[str, str]]:
        """The columns by their names in the data set, in SI units; and the source of each, with its unit."""
        units = stated_units(self.options.units_in(self.file.file))
        columns: dict[str, Cells] = {}
        read_from: dict[str, str] = {}
        for column, source in self.chosen.items():
            quantity = self.quantities.get(column, TEXT)
            unit = unit_of(units, quantity or NONE, source)
            read_from[column] = f"{source} [{unit}{'/s' * column.startswith('qd_')}]" if unit else source
            if quantity is TEXT or not any(self.file.cells(source)):  # an empty one may be optional
                columns[column] = self._texts(column, source)
                continue
            numbers = (FACTORS[quantity][unit] if quantity else 1.0) * self._numbers(source)
            is_further = column.startswith(COMMAND)  # and kept as texts, though it has a unit
            columns[column] = tuple(map(repr, numbers.tolist())) if is_further else numbers
        for names, words in ((EULER, f"Euler angles {self.options.euler}"), (ROTATION_VECTOR, "rotation vector")):
            if names[0] in self.chosen:
                sources = [self.chosen[name] for name in names]
                turned = f"{words} of {', '.join(sources)} [{unit_of(units, ANGLE, sources[0])}]"
                read_from |= dict.fromkeys(QUATERNION, turned)
        if number_poses and "pose" not in self.chosen:
            columns["pose"], read_from["pose"] = tuple(map(str, self.file.lines)), "(number of the row)"
        if self.name == POINTS and "point" not in self.chosen:
            point = self.options.point or ""
            columns["point"], read_from["point"] = (point,) * len(self.file), f"({point})"
        return CsvTable(self.file.file, columns, self.file.lines), read_from

    def _texts(self, column: str, source: str) -> tuple[str, ...]:
        cells = self.file.cells(source)
        if column in self.quantities:
            return cells
        plain = tuple(self._plain(cell) for cell in cells)  # a further column, perhaps of numbers
        return plain if np.isfinite([finite(cell) for cell in plain]).all() else cells

    def _numbers(self, source: str) -> Array:
        cells = self.file.cells(source)
        values = np.array([finite(self._plain(cell)) for cell in cells], dtype=np.float64)
        for i in np.flatnonzero(~np.isfinite(values))[:1]:
            other = "," if self.options.decimal == "." else "."
            hint = f". If {other!r} is the decimal sign, add --decimal {other!r}" if other in cells[i] else ""
            raise bad_cell(self.file.file, self.file.lines[i], source, cells[i], f"a finite number{hint}")
        return values

    def _plain(self, cell: str) -> str:
        """A cell with a decimal point; one with a point and another sign is no number."""
        sign = self.options.decimal
        return cell if sign == "." else f"'{cell}'" if "." in cell else cell.replace(sign, ".")


def choose(
    files: Mapping[str, CsvTable], known: Mapping[str, ColumnQuantities], options: ImportOptions
) -> tuple[dict[str, ColumnReader], tuple[str, ...]]:
    """Choose by `--column`, by equal names in the file and the data set, or by numbered joints.

    `poses.` or `points.` before a name selects the table, where both have such a column. The files, by table, may be
    the same; `known` are the columns of each that can be read.

    Returns:
        How the columns of each table are read; and the columns of the files that are not read.
    """
    poses, points = files[POSES], files.get(POINTS)
    chosen: dict[str, dict[str, str]] = {owner: {} for owner in files}
    for name, source in options.columns.items():
        if name.startswith("q_") and options.robot is None:
            raise UsageError(f"--column {name}: no such column. Name the arm with --robot, whose joints then have one.")
        owners, column = _owners(name, known)
        for owner in owners:
            if source not in files[owner]:
                hint = near(source, files[owner].columns)
                message = f"{files[owner].file} has no column '{source}', which --column {name}={source} names.{hint}"
                raise DataError(message, file=files[owner].file, column=source)
            chosen[owner][column] = source
    shared = known[POSES].keys() & known[POINTS].keys() - {"pose"} if poses is points else set()
    for owner, file in files.items():
        for column in known[owner]:
            if column in file and column not in shared:
                chosen[owner].setdefault(column, column)
    if options.robot is not None:
        joints = options.robot.joints
        if not chosen[POSES].keys() & {f"q_{joint}" for joint in joints}:
            chosen[POSES] |= joint_columns(poses, joints)
    _check_poses(poses, chosen[POSES], options)
    if points is not None:
        places = {f"{axis}_m": axis for axis in "xyz"}  # of points: the flange's pose follows from the joints
        left = known[POINTS].keys() - chosen[POINTS].keys()
        if options.robot is not None and places.keys() <= left and all(axis in points for axis in "xyz"):
            chosen[POINTS] |= places
        _check_points(points, poses, chosen[POINTS], known[POINTS], options)
    used = {(files[owner].file, source) for owner, sources in chosen.items() for source in sources.values()}
    tables = [poses] if points is None or poses is points else [poses, points]
    left_out = [f"{table.file}: {name}" for table in tables for name in table.columns if (table.file, name) not in used]
    readers = {owner: ColumnReader(owner, file, chosen[owner], known[owner], options) for owner, file in files.items()}
    return readers, tuple(left_out)


def joint_columns(table: CsvTable, joints: Sequence[str]) -> dict[str, str]:
    """The columns with the readings of joints, by `q_JOINT`, where they have other names; else none.

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


def _owners(name: str, known: Mapping[str, ColumnQuantities]) -> tuple[list[str], str]:
    """The tables of a name in `--column`, and the column's name there."""
    table, _, column = name.partition(".")
    if table == POSES and column:
        return [POSES], column  # any further column is kept
    if table == POINTS and column in known.get(POINTS, ()):
        return [POINTS], column
    owners = [owner for owner, quantities in known.items() if name in quantities]
    if not owners:
        meant = near(name, dict.fromkeys(column for quantities in known.values() for column in quantities))
        raise UsageError(f"--column {name}: no such column.{meant} A further column of poses.csv is poses.NAME.")
    if len(owners) > 1 and name != "pose":
        raise UsageError(f"--column {name}: of the flange or of the point? Write poses.{name} or points.{name}.")
    return owners, name


def _check_poses(file: CsvTable, chosen: Chosen, options: ImportOptions) -> None:
    if options.euler is not None and EULER[0] not in chosen:
        raise UsageError(f"--euler {options.euler}: of which columns? Name them with --column euler_1=NAME and so on.")
    if options.robot is not None:
        _all_there(file, [f"q_{joint}" for joint in options.robot.joints], chosen)
        return
    _all_there(file, XYZ, chosen, "poses.", "the position of the flange (or name the arm with --robot)")
    stated = [columns for columns in ORIENTATIONS if chosen.keys() & set(columns)]
    if len(stated) != 1:
        ways = "; ".join(", ".join(columns) for columns in ORIENTATIONS)
        raise UsageError(
            f"{file.file}: which columns are the flange's orientation? Name one of these sets with --column: {ways}."
        )
    _all_there(file, stated[0], chosen)
    if stated[0] == EULER and options.euler is None:
        raise UsageError(
            "About which axes are the Euler angles? State --euler, such as ZYX (rotating) or zyx (fixed axes)."
        )


def _check_points(
    file: CsvTable, poses: CsvTable, chosen: Chosen, known: ColumnQuantities, options: ImportOptions
) -> None:
    _all_there(file, [name for name in known if name not in ("pose", "point", "repeat")], chosen, "points.")
    if file is not poses and "pose" in known:
        _all_there(file, ["pose"], chosen, what="the pose in which each point was measured")
    if "point" in chosen and options.point is not None:
        raise UsageError(
            f"--point {options.point}: the column '{chosen['point']}' names the points. Leave one of them out."
        )
    if "point" not in chosen and options.point is None:
        raise UsageError(
            f"{file.file}: which point is measured in each row? Name a column with --column point=NAME or, if all are"
            " the same, that point with --point NAME."
        )


def _all_there(file: CsvTable, columns: Sequence[str], chosen: Chosen, prefix: str = "", what: str = "") -> None:
    for column in columns:
        if column not in chosen:
            raise UsageError(
                f"{file.file}: which column is {what or column}? Name it with --column {prefix}{column}=NAME."
                f"{near(column, file.columns)}"
            )


def with_quaternions(table: CsvTable, sequence: str | None) -> CsvTable:
    """The table with quaternions, if it has Euler angles or rotation vectors [rad] instead."""
    if EULER[0] in table:
        from scipy.spatial.transform import Rotation  # noqa: PLC0415 - slow to import

        try:
            angles = table.numbers(EULER)  # older versions of SciPy refuse none
            R = Rotation.from_euler(sequence or "", angles).as_matrix() if len(angles) else np.empty((0, 3, 3))
        except ValueError:  # SciPy names the sequence, but not the option
            raise UsageError(
                f"--euler {sequence!r}: expected three axes, such as ZYX (rotating) or zyx (fixed)."
            ) from None
    elif ROTATION_VECTOR[0] in table:
        R = exp_so3(table.numbers(ROTATION_VECTOR))
    else:
        return table
    kept = {name: cells for name, cells in table.columns.items() if name not in (*EULER, *ROTATION_VECTOR)}
    return replace(table, columns=kept | dict(zip(QUATERNION, to_quaternion(R).T, strict=True)))
