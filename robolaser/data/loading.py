"""The data set's folder on disk ⇄ typed arrays; everything is checked on the way in."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.csv_tables import Table, read_table, read_text
from robolaser.data.dataset import Board, Dataset, Noise, Points, Poses
from robolaser.data.sensor_format import XYZ, SensorFormat, sensor_format
from robolaser.data.toml_schema import Settings, read_settings
from robolaser.errors import (
    BadCell,
    FileUnreadable,
    FormatUnknown,
    JointOutOfRange,
    NotADataset,
    NotAPixel,
    NotARotation,
    PathLeaves,
    PoseUnknown,
    RowTwice,
    SettingMissing,
    SettingWrong,
    TooFar,
)
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.rigid_motion import from_quaternion, pose
from robolaser.geometry.robots import find_robot

FORMAT = "robolaser-dataset/1"
FLANGE_COLUMNS = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
AT_THE_POSE = ("payload_kg", "temperature_c")
OUT_OF_RANGE_RAD = 1.0  # real arms stand a little outside their URDF's limits; nobody by a radian
FARTHEST_M = 200.0  # a laser tracker's range; larger numbers are millimetres
QUATERNION_SLACK = 0.01  # files round their digits
GRAVITY = (0.0, 0.0, -9.81)


def load(folder: str | Path) -> Dataset:
    """Read and check a data set.

    Args:
        folder: Holds dataset.toml, poses.csv and, once there are points, points.csv.

    Raises:
        RobolaserError: With file, row and column of what is wrong.
    """
    folder = Path(folder)
    settings, said = _read(folder)
    warnings = settings.passed_over()
    poses = _poses(read_table(folder / "poses.csv", _readings(said.robot)), said.robot, folder, warnings)
    has_points = (folder / "points.csv").is_file()
    points = said.points
    if has_points:
        columns = [column for group in said.format.columns.values() for column in group]
        points = _points(read_table(folder / "points.csv", ["repeat", *columns]), poses, said.format, said.image_px)
        silent = [poses.names[i] for i in np.flatnonzero(np.bincount(points.pose, minlength=len(poses)) == 0)]
        if silent:
            warnings.append(f"{len(silent)} of {len(poses)} poses have no points: {_some(silent)}.")
    sockets = sorted(set(points.names))
    target = settings.section("target")
    return replace(
        said,
        poses=poses,
        points=points,
        distances_m=target.distances("distances_m", sockets) if said.format.named_points else (),
        warnings=tuple(warnings),
    )


def describe(folder: str | Path) -> Dataset:
    """Read and check dataset.toml alone: robot, sensor and target, without a pose.

    Raises:
        RobolaserError: With the key of what is wrong.
    """
    settings, said = _read(Path(folder))
    return replace(said, warnings=tuple(settings.passed_over()))


def _read(folder: Path) -> tuple[Settings, Dataset]:
    if not (folder / "dataset.toml").is_file():
        raise NotADataset(folder)
    settings = read_settings(folder / "dataset.toml")
    found = settings.text("format")
    if found != FORMAT:
        raise FormatUnknown("dataset.toml", found, FORMAT)

    kind = settings.section("sensor").text("kind", default="stripe")
    declared = sensor_format(kind)
    arm, sensor, scanner = (settings.section(name) for name in ("robot", "sensor", "scanner"))
    image, target, noise = (settings.section(name) for name in ("image", "target", "noise"))
    quat = scanner.numbers("bracket_quat", 4, default=(0.0, 0.0, 0.0, 1.0))
    norm = float(np.linalg.norm(quat))
    if abs(norm - 1) > QUATERNION_SLACK:
        raise NotARotation("dataset.toml, [scanner] bracket_quat", norm)
    return settings, Dataset(
        name=settings.text("name", default=folder.resolve().name),
        source=settings.text("source", default=""),
        licence=settings.text("licence", default=""),
        kind=kind,
        robot=_robot(settings, folder) if "robot" in settings else None,
        poses=Poses(()),
        points=_none(),
        parameters=settings.section("parameters").parameters(),
        stripe_axis=sensor.text("stripe_axis", default="u", one_of=("u", "v")),
        bracket_quat=(quat[0], quat[1], quat[2], quat[3]),
        angles=scanner.text("angles", default="xyz", one_of=("xyz", "zyz")),
        image_px=_image(image) if "image" in declared.required else None,
        board=_board(settings.section("board")) if "board" in settings else None,
        placed=target.flag("placed", default=True),
        noise=Noise(**{key: noise.number(key, positive=True) for key in Noise.__annotations__ if key in noise}),
        time_is_order=arm.text("time", default="seconds", one_of=("seconds", "order")) == "order",
        path_known=arm.text("path", default="consecutive", one_of=("consecutive", "unknown")) == "consecutive",
        folder=folder,
    )


def inside(folder: Path, path: str, where: str) -> Path:
    """A path of the data set, which must stay within its folder.

    Raises:
        PathLeaves: It points elsewhere.
    """
    whole = folder / path
    if "\0" in path or Path(path).is_absolute() or not whole.resolve().is_relative_to(folder.resolve()):
        raise PathLeaves(where, path)
    return whole


def _robot(settings: Settings, folder: Path) -> Robot:
    arm = settings.section("robot")
    urdf = arm.text("urdf")
    flange = arm.text("flange")
    joints = arm.texts("joints")
    if joints is None:
        raise SettingMissing("[robot] joints", "the names of the joints in poses.csv")
    gravity = arm.numbers("gravity", 3, default=GRAVITY)
    path = inside(folder, urdf, "dataset.toml, [robot] urdf")
    if path.is_file():
        text, source = read_text(path), urdf
    elif urdf.endswith((".urdf", ".xml")) or "/" in urdf:
        raise FileUnreadable(path, "no such file")
    else:
        text, source = find_robot(urdf).urdf, urdf
    return Robot.from_urdf(
        text, flange=flange, joints=joints, gravity=(gravity[0], gravity[1], gravity[2]), source=source
    )


def _image(settings: Settings) -> tuple[int, int]:
    return settings.count("width_px", least=1), settings.count("height_px", least=1)


def _board(settings: Settings) -> Board:
    return Board(
        columns=settings.count("columns", least=3),
        rows=settings.count("rows", least=3),
        square_m=settings.number("square_m", positive=True),
    )


def _readings(robot: Robot | None) -> list[str]:
    """Columns of poses.csv that are numbers."""
    if robot is None:
        return ["time_s", *FLANGE_COLUMNS]
    return ["time_s", *(f"{what}_{joint}" for what in ("q", "qd") for joint in robot.joints)]


def _poses(table: Table, robot: Robot | None, folder: Path, warnings: list[str]) -> Poses:
    names = table.texts("pose")
    _all_different(table, names, "pose")
    if not names:
        raise BadCell(table.file, 2, "pose", "", "at least one pose")
    known = {"pose", "time_s", "image", *AT_THE_POSE}
    poses = Poses(names)
    if "time_s" in table:
        poses = replace(poses, time_s=table.numbers(["time_s"])[:, 0])
    poses = replace(poses, payload_kg=_stated(table, "payload_kg"), temperature_c=_stated(table, "temperature_c"))
    if "image" in table.columns:
        images = tuple(table.columns["image"])
        for line, image in zip(table.lines, images, strict=True):
            inside(folder, image, f"poses.csv, row {line}, column image")
        poses = replace(poses, image=images)
    if robot is None:
        numbers = table.numbers(FLANGE_COLUMNS)
        _not_too_far(table, numbers[:, :3])
        norms = np.linalg.norm(numbers[:, 3:], axis=1)
        for row in np.flatnonzero(np.abs(norms - 1) > QUATERNION_SLACK)[:1]:
            raise NotARotation(f"poses.csv, row {table.lines[row]}", float(norms[row]))
        known |= set(FLANGE_COLUMNS)
        poses = replace(poses, T_base_flange=pose(from_quaternion(numbers[:, 3:]), numbers[:, :3]))
    else:
        q_columns = [f"q_{joint}" for joint in robot.joints]
        qd_columns = [f"qd_{joint}" for joint in robot.joints]
        q = table.numbers(q_columns)
        warnings += _limits(table, q, robot)
        unread = [column for column in table.columns if column.startswith("q_") and column not in q_columns]
        if unread:
            warnings.append(
                f"poses.csv has {_some(unread)}, but [robot] joints in dataset.toml does not list "
                f"{'that joint' if len(unread) == 1 else 'those joints'}: taken to stay at neutral."
            )
        has_speed = any(column in table for column in qd_columns)
        known |= {*q_columns, *qd_columns}
        poses = replace(poses, q=q, qd=table.numbers(qd_columns) if has_speed else None)
    return replace(poses, extra={name: cells for name, cells in table.columns.items() if name not in known})


def _stated(table: Table, column: str) -> Array | None:
    """A column that may be absent or empty throughout, but not in part, (n,)."""
    return table.numbers([column])[:, 0] if column in table and any(table.columns.get(column, ("",))) else None


def _limits(table: Table, q: Array, robot: Robot) -> list[str]:
    beyond = np.maximum(q - robot.upper, robot.lower - q)
    if (beyond > OUT_OF_RANGE_RAD).any():
        i, j = np.argwhere(beyond > OUT_OF_RANGE_RAD)[0]
        unit = "m" if robot.prismatic[j] else "rad"
        raise JointOutOfRange(
            table.lines[i], robot.joints[j], float(q[i, j]), float(robot.lower[j]), float(robot.upper[j]), unit
        )
    return [
        f"{int((beyond[:, j] > 0).sum())} readings of {joint} lie up to {beyond[:, j].max():.3g} "
        f"{'m' if robot.prismatic[j] else 'rad'} outside its limits in the URDF."
        for j, joint in enumerate(robot.joints)
        if (beyond[:, j] > 0).any()
    ]


def _points(table: Table, poses: Poses, declared: SensorFormat, image_px: tuple[int, int] | None) -> Points:
    of_name = {name: i for i, name in enumerate(poses.names)}
    in_pose, names = table.texts("pose"), table.texts("point")
    strangers = set(in_pose) - set(of_name)
    if strangers:
        row = min(map(in_pose.index, strangers))
        raise PoseUnknown(table.lines[row], in_pose[row], poses.names)
    number = np.fromiter(map(of_name.__getitem__, in_pose), np.int64, len(in_pose))
    points = Points(number, names)
    if "repeat" in table:
        points = replace(points, repeat=_whole(table, "repeat"))
    _no_point_twice(table, points, in_pose)
    for column, why in declared.absent.items():
        if column in table:
            raise SettingWrong("[sensor] kind", declared.kind, f"points.csv without {column}: {why}")
    arrays = {name: table.numbers(columns) for name, columns in declared.columns.items()}
    if "xyz" in arrays:
        _not_too_far(table, arrays["xyz"])
    if "pixel" in arrays and image_px is not None:
        _in_the_image(table, arrays["pixel"], image_px)
    pixel, xyz = arrays.pop("pixel", None), arrays.pop("xyz", None)
    return replace(points, pixel=pixel, xyz=xyz, columns=arrays)


def _in_the_image(table: Table, pixel: Array, image_px: tuple[int, int]) -> None:
    outside = ((pixel < -0.5) | (pixel > np.array(image_px) - 0.5)).any(axis=1)
    if outside.any():
        row = int(np.argmax(outside))
        raise NotAPixel(table.lines[row], float(pixel[row, 0]), float(pixel[row, 1]), image_px)


def _no_point_twice(table: Table, points: Points, in_pose: tuple[str, ...]) -> None:
    key = points.pose * (points.number.max(initial=0) + 1) + points.number
    if points.repeat is not None:
        shot = points.repeat - points.repeat.min(initial=0)
        key = key * (shot.max(initial=0) + 1) + shot
    if (np.diff(key) > 0).all():
        return
    order = np.argsort(key, kind="stable")
    same = np.diff(key[order]) == 0
    if same.any():
        at = int(np.argmin(np.where(same, order[1:], len(points))))  # the first row that repeats another
        first, row = order[at], order[at + 1]
        what = "" if points.repeat is None else f", repeat {points.repeat[row]}"
        raise RowTwice(
            table.file,
            table.lines[row],
            table.lines[first],
            f"pose {in_pose[row]}, point {points.names[row]}{what}",
        )


def _whole(table: Table, column: str) -> Ints:
    numbers = table.numbers([column])[:, 0]
    for i in np.flatnonzero(numbers != np.round(numbers))[:1]:
        raise BadCell(table.file, table.lines[i], column, f"{numbers[i]:.12g}", "a whole number")
    return numbers.astype(np.int64)


def _none() -> Points:
    return Points(np.empty(0, dtype=np.int64), ())


def _all_different(table: Table, keys: "list[str] | tuple[str, ...]", what: str) -> None:
    first: dict[str, int] = {}
    for line, key in zip(table.lines, keys, strict=True):
        if key in first:
            raise RowTwice(table.file, line, first[key], f"{what} {key}")
        first[key] = line


def _not_too_far(table: Table, xyz: Array) -> None:
    if max(xyz.max(initial=0.0), -xyz.min(initial=0.0)) > FARTHEST_M:
        i, j = np.argwhere(np.abs(xyz) > FARTHEST_M)[0]
        raise TooFar(table.file, table.lines[i], XYZ[j], float(xyz[i, j]))


def _some(names: list[str]) -> str:
    return ", ".join(names[:5]) + (" ..." if len(names) > 5 else "")
