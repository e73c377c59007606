"""poses.csv and points.csv: the arm's poses and the measured points, checked cell by cell."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.csv_tables import CsvTable, bad_cell, bad_row, finite, read_table
from robolaser.data.dataset import COMMAND, Dataset, Points, Poses
from robolaser.data.dataset_file import QUATERNION_SLACK, check_rotation, inside
from robolaser.data.sensor_format import PIXEL, QUATERNION, XYZ
from robolaser.data.toml_schema import wrong
from robolaser.errors import DataError, meant
from robolaser.geometry.rigid_motion import from_quaternion, pose
from robolaser.robot.kinematics import Robot

FILE = "poses.csv"
FLANGE_COLUMNS = (*XYZ, *QUATERNION)
MOST_PAYLOAD = 2.0  # times the mass of an arm's links: real arms carry less than their own mass
OUT_OF_RANGE_RAD = 1.0  # real arms exceed their URDF's limits a little, but not by a radian
FARTHEST_M = 200.0  # range of a laser tracker; larger numbers are millimetres
IMAGES = "image"  # prefix of columns with paths of images
MOST_NAMED = 5


def read_poses(path: Path, robot: Robot | None) -> tuple[Poses, list[str]]:
    """The poses of poses.csv, with joint angles of a robot or, without one, measured flange poses; and warnings."""
    return poses_of(read_table(path, ["time_s", *_readings(robot)]), path.parent, robot)


def _readings(robot: Robot | None) -> Sequence[str]:
    return FLANGE_COLUMNS if robot is None else [f"{q}_{joint}" for q in ("q", "qd") for joint in robot.joints]


def poses_of(table: CsvTable, folder: Path, robot: Robot | None) -> tuple[Poses, list[str]]:
    """The poses of a table with the columns of poses.csv; see `read_poses`."""
    names = table.texts("pose")
    table.check_all_differ(names, lambda row: f"pose {names[row]}")
    if not names:
        raise DataError(f"{table.file} has a header, but no row of a pose.", file=table.file)
    known = {"pose", "time_s", IMAGES, "payload_kg", "temperature_c", "session", *_readings(robot)}
    poses = Poses(
        names,
        time_s=table.numbers(["time_s"])[:, 0] if "time_s" in table else None,
        image=_images(table, folder) if IMAGES in table else None,
        payload_kg=_stated(table, "payload_kg"),
        temperature_c=_stated(table, "temperature_c"),
        session=table.texts("session") if "session" in table else None,
        extra={name: table.cells(name) for name in table.columns if name not in known},
    )
    warnings: list[str] = []
    if robot is None:
        poses = replace(poses, T_base_flange=motions_of(table))
    else:
        joints = robot.joints
        q_columns, qd_columns = ([f"{q}_{joint}" for joint in joints] for q in ("q", "qd"))
        q = table.numbers(q_columns)
        qd = table.numbers(qd_columns) if any(column in table for column in qd_columns) else None
        warnings += [*outside_limits(table, q, robot), *_unlisted(table, q_columns), *_too_heavy(table, poses, robot)]
        commanded = [joint for joint in joints if f"{COMMAND}{joint}" in table]
        commands = table.numbers([f"{COMMAND}{joint}" for joint in commanded])
        following = {joint: commands[:, i] - q[:, joints.index(joint)] for i, joint in enumerate(commanded)}
        poses = replace(poses, q=q, qd=qd, following=following)
    return poses, [*warnings, *_no_coordinates(table, poses)]


def _not_too_far(table: CsvTable, xyz: Array) -> None:
    """Check that positions are in metres: none is beyond the reach of arms and trackers."""
    if max(xyz.max(initial=0.0), -xyz.min(initial=0.0)) > FARTHEST_M:
        i, j = np.argwhere(np.abs(xyz) > FARTHEST_M)[0]
        message = f"{xyz[i, j]:.6g} m is farther than any arm reaches. Are these millimetres? Lengths are metres."
        raise bad_row(table.file, table.lines[i], message, XYZ[j])


def _check_quaternions(table: CsvTable, quaternions: Array) -> None:
    """Check that quaternions (rows, 4) are rotations."""
    lengths = np.linalg.norm(quaternions, axis=1)
    for i in np.flatnonzero(np.abs(lengths - 1) > QUATERNION_SLACK)[:1]:
        row, columns = table.lines[i], " ".join(QUATERNION)
        check_rotation(quaternions[i], f"{table.file}, row {row}, columns {columns}", table.file, row, columns)


def some(names: list[str]) -> str:
    """The first few of many names."""
    more = len(names) - MOST_NAMED
    return ", ".join(names[:MOST_NAMED]) + (f", and {more} more" if more > 0 else "")


def _images(table: CsvTable, folder: Path) -> tuple[str, ...]:
    images = table.cells(IMAGES)
    for line, image in zip(table.lines, images, strict=True):
        inside(folder, image, f"{table.file}, row {line}, column {IMAGES}")
    return images


def _stated(table: CsvTable, column: str) -> Array | None:
    """A column that may be absent or empty throughout, but not in part, (n,)."""
    cells = table.columns.get(column, ())
    is_stated = any(cells) if isinstance(cells, tuple) else len(cells) > 0
    return table.numbers([column])[:, 0] if is_stated else None


def motions_of(table: CsvTable) -> Array:
    """The rigid motions of a table's rows, by their columns `x_m` to `qw`, (rows, 4, 4)."""
    numbers = table.numbers(FLANGE_COLUMNS)
    _not_too_far(table, numbers[:, :3])
    _check_quaternions(table, numbers[:, 3:])
    return pose(from_quaternion(numbers[:, 3:]), numbers[:, :3])


def _too_heavy(table: CsvTable, poses: Poses, robot: Robot) -> list[str]:
    """A warning of a payload that no arm of this mass carries."""
    arm_kg = float(robot.by_pinocchio.masses.sum())
    if poses.payload_kg is None or not 0.0 < MOST_PAYLOAD * arm_kg < poses.payload_kg.max():
        return []
    row = int(poses.payload_kg.argmax())
    return [
        f"{table.file}, row {table.lines[row]}: payload_kg is {poses.payload_kg[row]:.4g}, but the links of"
        f" {robot.name} weigh {arm_kg:.3g} kg together. Are these grams?"
    ]


def outside_limits(table: CsvTable, q: Array, robot: Robot) -> list[str]:
    """Warnings of unlikely joint values, (n, j); a DataError for those of another unit or column: far beyond limits."""
    beyond = np.maximum(q - robot.upper, robot.lower - q)
    units = ["m" if prismatic else "rad" for prismatic in robot.prismatic]
    for i, j in np.argwhere(beyond > OUT_OF_RANGE_RAD)[:1]:
        joint, line = robot.joints[j], table.lines[i]
        raise DataError(
            f"{table.file}, row {line}: q_{joint} is {q[i, j]:.4g} {units[j]}, but the URDF limits {joint} to "
            f"{robot.lower[j]:.2f} .. {robot.upper[j]:.2f} {units[j]}. "
            + (_exchanged(q, robot) or f"Are these {'millimetres' if robot.prismatic[j] else 'degrees'}?"),
            file=table.file,
            row=line,
            column=f"q_{joint}",
        )
    exchanged = _exchanged(q, robot) if (beyond > 0).any() else ""
    return [
        f"{outside} reading{'s' * (outside != 1)} of {joint} {'are up to' if outside != 1 else 'is'} "
        f"{beyond[:, j].max():.3g} {units[j]} outside its limits in the URDF. {exchanged}".rstrip()
        for j, joint in enumerate(robot.joints)
        if (outside := int((beyond[:, j] > 0).sum()))
    ]


def _exchanged(q: Array, robot: Robot) -> str:
    """A question, if all readings are within their limits after exchanging two columns, and by no other exchange."""
    pairs = []
    for a, b in combinations(range(len(robot.joints)), 2):
        other = q.copy()
        other[:, [a, b]] = q[:, [b, a]]
        if ((other >= robot.lower) & (other <= robot.upper)).all():
            pairs.append((robot.joints[a], robot.joints[b]))
    return f"Are the columns q_{pairs[0][0]} and q_{pairs[0][1]} exchanged?" if len(pairs) == 1 else ""


def _unlisted(table: CsvTable, q_columns: list[str]) -> list[str]:
    commands = [f"{COMMAND}{column.removeprefix('q_')}" for column in q_columns]
    unread = [column for column in table.columns if column.startswith("q_") and column not in (*q_columns, *commands)]
    if not unread:
        return []
    which = "that joint" if len(unread) == 1 else "those joints"
    return [
        f"{table.file} has {some(unread)}, but [robot] joints in dataset.toml does not list {which}:"
        " taken to stay at neutral."
    ]


def _no_coordinates(table: CsvTable, poses: Poses) -> list[str]:
    """Warnings of further columns that cannot be coordinates of a gap: neither numbers nor empty throughout."""
    warnings = []
    for name, cells in poses.extra.items():
        if name not in poses.coordinates and any(cells) and not name.startswith((IMAGES, COMMAND)):
            row = next(row for row, cell in zip(table.lines, cells, strict=True) if not np.isfinite(finite(cell)))
            odd = f"{table.file}, column {name} is not a number in every row (row {row}): it is kept"
            warnings.append(f"{odd}, but the diagnosis does not look for a gap along it.")
    return warnings


LARGEST_REPEAT = 1e9


def points_of(table: CsvTable, described: Dataset) -> Points:
    """The points of a table with the columns of points.csv, perhaps as texts, for a data set that lacks only these."""
    declared = described.format
    in_pose = table.texts("pose")
    points = Points(_numbers_of(table, in_pose, described.poses.names), table.texts("point"))
    if "repeat" in table:
        points = replace(points, repeat=_repeats(table))
    if not declared.many_rows:
        shots = points.place
        if points.repeat is not None:
            repeat = np.unique(points.repeat, return_inverse=True)[1]
            shots = shots * (repeat.max(initial=0) + 1) + repeat
        table.check_all_differ(shots.tolist(), lambda row: _shown(points, row, in_pose[row]))
    for column, why in declared.absent.items():
        if column in table:
            raise wrong("dataset.toml", ("sensor", "kind"), declared.kind, f"{table.file} without {column}: {why}")
    arrays = {name: table.numbers(columns) for name, columns in declared.columns.items()}
    if "xyz" in arrays:
        _not_too_far(table, arrays["xyz"])
    if "quaternion" in arrays:
        _check_quaternions(table, arrays["quaternion"])
    if "pixel" in arrays and described.image_px is not None:
        _in_the_image(table, arrays["pixel"], described.image_px)
    if "pixel" in arrays:
        _not_at_one_pixel(table, points, arrays["pixel"])
    return points.with_arrays(arrays)


def _numbers_of(table: CsvTable, in_pose: Sequence[str], poses: Sequence[str]) -> Ints:
    """Number of each row's pose, (m,)."""
    number = {name: i for i, name in enumerate(poses)}
    strangers = set(in_pose) - set(number)
    if strangers:
        row = min(map(in_pose.index, strangers))
        there = f"no pose {in_pose[row]!r} in poses.csv, which has {len(poses)}.{meant(in_pose[row], poses)}"
        raise bad_row(table.file, table.lines[row], f"{there} Add the pose or delete the row.", "pose")
    return np.fromiter(map(number.__getitem__, in_pose), np.int64, len(in_pose))


def _repeats(table: CsvTable) -> Ints:
    numbers = table.numbers(["repeat"])[:, 0]
    for i in np.flatnonzero((numbers != np.round(numbers)) | (np.abs(numbers) > LARGEST_REPEAT))[:1]:
        expected = f"a whole number up to {LARGEST_REPEAT:.0g}"
        raise bad_cell(table.file, table.lines[i], "repeat", f"{numbers[i]:.12g}", expected)
    return numbers.astype(np.int64)


def _shown(points: Points, row: int, pose: str) -> str:
    repeat = "" if points.repeat is None else f", repeat {points.repeat[row]}"
    return f"pose {pose}, point {points.names[row]}{repeat}"


def _in_the_image(table: CsvTable, pixel: Array, image_px: tuple[int, int]) -> None:
    for row, axis in np.argwhere((pixel < -0.5) | (pixel > np.array(image_px) - 0.5))[:1].tolist():
        raise bad_row(
            table.file,
            table.lines[row],
            f"pixel ({pixel[row, 0]:.6g}, {pixel[row, 1]:.6g}) is outside the image of {image_px[0]} x {image_px[1]}"
            " pixels. Correct the row, or [image] in dataset.toml.",
            PIXEL[axis],
        )


def _not_at_one_pixel(table: CsvTable, points: Points, pixel: Array) -> None:
    """Check that no pose has several points that are all at one pixel."""
    _, first, pose = np.unique(points.pose, return_index=True, return_inverse=True)
    apart = np.bincount(pose, (pixel != pixel[first][pose]).any(axis=1))
    places = np.bincount(pose[np.unique(points.place, return_index=True)[1]])
    for row in first[(apart == 0) & (places > 1)][:1].tolist():
        there = f"({pixel[row, 0]:.6g}, {pixel[row, 1]:.6g})"
        here = f"all points of pose {table.texts('pose')[row]} are at one pixel, {there}"
        raise bad_row(table.file, table.lines[row], f"{here}. Are these the right columns? Otherwise delete the rows.")
