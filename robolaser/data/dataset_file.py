"""dataset.toml: its keys, and the robot, sensor, target and parameters that it describes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, final

import numpy as np
from msgspec import Meta
from numpy.typing import ArrayLike

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.sensor_format import SensorFormat, sensor_format
from robolaser.data.sessions import OWN, Sessions
from robolaser.data.several_sensors import described_members
from robolaser.data.stated_noise import Noise
from robolaser.data.toml_schema import Positive, lacking, read_toml, refused, typed, wrong
from robolaser.errors import DataError, UsageError, unreadable
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import DOWN, Robot

FILE = "dataset.toml"
FULL_TURN = 2 * np.pi
FORMAT = "robolaser-dataset/1"
QUATERNION_SLACK = 0.01  # files round their digits

NonEmpty = Annotated[str, Meta(min_length=1)]
Pixels = Annotated[int, Meta(ge=1, le=100_000)]


@final
@dataclass(frozen=True)
class RobotTable:
    """`[robot]`."""

    urdf: NonEmpty
    flange: NonEmpty
    joints: Annotated[tuple[NonEmpty, ...], Meta(min_length=1)]
    gravity: tuple[float, float, float] = DOWN
    time: Literal["seconds", "order"] = "seconds"
    path: Literal["consecutive", "unknown"] = "consecutive"


@final
@dataclass(frozen=True)
class RunTable:
    """`[robot]` where flange poses were measured."""

    time: Literal["seconds", "order"] = "seconds"
    path: Literal["consecutive", "unknown"] = "consecutive"


@final
@dataclass(frozen=True)
class SensorTable:
    """`[sensor]`, of a kind without options."""

    stripe_axis: Literal["u", "v"] = "u"


@final
@dataclass(frozen=True)
class ScannerTable:
    """`[scanner]`."""

    bracket_quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
    angles: Literal["xyz", "zyz"] = "xyz"


@final
@dataclass(frozen=True)
class ImageTable:
    """`[image]`."""

    width_px: Pixels
    height_px: Pixels


@final
@dataclass(frozen=True)
class TargetTable:
    """`[target]`."""

    placed: bool = True
    distances_m: tuple[tuple[str, str, Positive], ...] = ()
    radius_m: dict[str, Positive] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class SessionsTable:
    """`[sessions]`."""

    own: tuple[NonEmpty, ...] = OWN  # an empty one: all sessions share all


@final
@dataclass(frozen=True)
class DatasetFile:
    """The whole file."""

    format: str
    name: str = ""
    source: str = ""
    licence: str = ""
    robot: dict[str, Any] | None = None
    sensor: dict[str, Any] = field(default_factory=dict)
    scanner: ScannerTable = ScannerTable()
    image: ImageTable | None = None
    board: Board | None = None
    target: TargetTable = TargetTable()
    noise: Noise = Noise()
    sessions: SessionsTable | None = None
    parameters: dict[str, Any] = field(default_factory=dict)


def describe(folder: str | Path) -> Dataset:
    """Read and check dataset.toml alone: robot, sensor and target, without a pose or a point.

    Raises:
        DataError: With the key of the error.
        RobotError: The URDF, its flange or its joints are not usable.
    """
    folder = Path(folder)
    contents = read_toml(folder / FILE, FORMAT, "A data set is a folder with dataset.toml, poses.csv and points.csv.")
    _refuse_motion(contents.get("sensor"))
    if "sensors" not in contents:
        return _described(contents, folder)
    members = described_members(contents, lambda one: _described(one, folder))
    several = replace(members[0].data, members=members)
    whole = typed({key: contents[key] for key in contents if key != "sensors"}, DatasetFile, file=FILE)
    parameters = parameters_of(whole.parameters, several.format)
    return replace(several, parameters=parameters, warnings=_unused(contents, several.format))


def _refuse_motion(sensor: object) -> None:
    if isinstance(sensor, dict) and sensor.get("kind") == "motion":
        why = (
            '"motion" is a log of a moving arm. `robolaser check`, `diagnose`, `calibrate` and `plan` read it, in'
            " Python `calibrate` and `diagnose`; this needs a sensor that measures points or poses."
        )
        raise refused(FILE, "[sensor] kind", why)


def _described(contents: Mapping[str, Any], folder: Path) -> Dataset:
    """A data set of one sensor."""
    read = typed(contents, DatasetFile, file=FILE)
    declared = sensor_format(read.sensor.get("kind", "stripe"))
    arm, run = _robot_table(read)
    _check(read, arm, declared)
    own_keys = {key: value for key, value in read.sensor.items() if key != "kind"}
    options: Any = typed(own_keys, declared.options or SensorTable, file=FILE, at=("sensor",))
    image = read.image if "image" in declared.tables else None
    return Dataset(
        name=read.name or folder.resolve().name,
        source=read.source,
        licence=read.licence,
        kind=declared.kind,
        options=options if declared.options else None,
        robot=None if arm is None else read_robot(arm, folder),
        poses=Poses(()),
        parameters=parameters_of(read.parameters, declared),
        stripe_axis=getattr(options, "stripe_axis", "u"),
        image_px=None if image is None else (image.width_px, image.height_px),
        board=read.board,
        noise=read.noise,
        time_is_order=run.time == "order",
        path_known=run.path == "consecutive",
        sessions=None if read.sessions is None else Sessions((), read.sessions.own),
        folder=folder,
        warnings=_unused(contents, declared),
        **vars(read.scanner),
        **vars(read.target),
    )


def _robot_table(read: DatasetFile) -> tuple[RobotTable | None, RobotTable | RunTable]:
    """The arm, if there is one, and how poses followed one another."""
    if read.robot is None or (read.robot and read.robot.keys() <= RunTable.__annotations__.keys()):
        return None, typed(read.robot or {}, RunTable, file=FILE, at=("robot",))
    arm = typed(read.robot, RobotTable, file=FILE, at=("robot",))
    return arm, arm


def _unused(contents: Mapping[str, Any], declared: SensorFormat) -> tuple[str, ...]:
    return tuple(
        f"{FILE}, [{table}] is not used: a {declared.title} has no use for it."
        for table in ("scanner", "image", "board")
        if table in contents and table not in declared.tables
    )


def inside(folder: Path, path: str, where: str) -> Path:
    """A path in the data set, checked to be inside its folder."""
    whole = folder / path
    if "\0" in path or Path(path).is_absolute() or not whole.resolve().is_relative_to(folder.resolve()):
        raise DataError(
            f"{where}: {path!r} leaves the data set's folder. Copy the file into it and give a relative path.",
            file=path,
        )
    return whole


def check_rotation(
    quaternion: ArrayLike, where: str, file: str, row: int | None = None, column: str | None = None
) -> None:
    """Check that a quaternion is a rotation."""
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1) > QUATERNION_SLACK:
        raise DataError(
            f"{where}: the quaternion (x, y, z, w) has length {length:.4g}, expected 1. "
            "Check the order of its four numbers, or normalise it.",
            file=file,
            row=row,
            column=column,
        )


def _check(read: DatasetFile, arm: RobotTable | None, declared: SensorFormat) -> None:
    check_rotation(read.scanner.bracket_quat, f"{FILE}, [scanner] bracket_quat", FILE)
    if arm is not None and len(set(arm.joints)) < len(arm.joints):
        raise wrong(FILE, ("robot", "joints"), list(arm.joints), "a list of different names")
    if arm is None and declared.needs_robot:
        raise lacking(FILE, "[robot]", f": a {declared.title} needs joint angles")
    for table in declared.required:
        if getattr(read, table) is None:
            raise lacking(FILE, f"[{table}]", f", which a {declared.title} needs")
    if read.board is not None:
        read.board.check()


def read_robot(table: RobotTable, folder: Path) -> Robot:
    """The arm that `[robot]` names.

    Raises:
        DataError: The URDF cannot be read, or there is no robot of that name.
        RobotError: Its flange or its joints are not usable.
    """
    path = inside(folder, table.urdf, f"{FILE}, [robot] urdf")
    if path.is_file():
        text = read_text(path, ROBOT_BYTES)
    elif table.urdf.endswith((".urdf", ".xml")) or "/" in table.urdf:
        raise unreadable(path, "it is not a regular file" if path.exists() else "no such file")
    else:
        try:
            text = find_robot(table.urdf).urdf
        except UsageError as error:
            raise DataError(f"{FILE}, [robot] urdf: {error}", file=FILE, column="urdf") from None
    return Robot.from_urdf(text, flange=table.flange, joints=table.joints, gravity=table.gravity, source=table.urdf)


@final
@dataclass(frozen=True)
class ParameterEntry:
    """One of `[parameters]`."""

    nominal: float
    lower: float | None = None
    upper: float | None = None
    fixed: bool = False


def parameters_of(table: Mapping[str, Any], declared: SensorFormat) -> dict[str, Parameter]:
    """Every key as a parameter; `target.x = ...` and `"target.x" = ...` are one."""
    found = {}
    for name, values in _entries(table):
        at = ("parameters", name)
        if not isinstance(values, dict):
            raise wrong(FILE, at, values, "{ nominal = ..., lower = ..., upper = ... }")
        entry = typed(values, ParameterEntry, file=FILE, at=at)
        reason = _fault(name, entry, declared)
        if reason:
            raise refused(FILE, f"[parameters] {name}", reason)
        lower, upper = (entry.nominal if end is None else end for end in (entry.lower, entry.upper))
        found[name] = Parameter(name, declared.unit_of(name), entry.nominal, lower, upper)
    return found


def _fault(name: str, entry: ParameterEntry, declared: SensorFormat) -> str:
    """The error of a parameter's numbers; "" where there is none."""
    nominal, lower, upper = entry.nominal, entry.lower, entry.upper
    if entry.fixed:
        if (lower, upper) != (None, None):
            return "it is fixed at its nominal value, and has no bounds. Delete fixed, or lower and upper."
        lower = upper = nominal
    elif lower is None or upper is None:
        missing = "lower" if lower is None else "upper"
        return f"{missing} is missing: expected a number, or fixed = true to hold it at its nominal value."
    elif not lower <= nominal <= upper or lower == upper:
        why = "the nominal value must lie between the bounds" if lower < upper else "lower must be below upper"
        return f"nominal {nominal:g}, lower {lower:g}, upper {upper:g}; {why}."
    if name in declared.positive and lower <= 0:
        return f"lower is {lower:g}, but this parameter is positive. Give a lower bound above zero."
    largest = max((nominal, lower, upper), key=abs)
    if declared.unit_of(name) == "rad" and abs(largest) > FULL_TURN:
        return f"{largest:g} rad is more than a full turn. Are these degrees?"
    return ""


def _entries(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and values; TOML reads a name with dots as nested tables."""
    known = set(ParameterEntry.__annotations__)
    for name, values in table.items():
        tables = isinstance(values, dict) and values and all(isinstance(value, dict) for value in values.values())
        if tables and not values.keys() & known:
            yield from ((f"{name}.{rest}", value) for rest, value in _entries(values))
        else:
            yield name, values
