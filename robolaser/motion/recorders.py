"""Logs of moving arms as recorders write them: SAGE's folders, LeRobot's data sets, tables, arrays, bags of ROS."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, final

import msgspec
import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import read_text
from robolaser.data.csv_tables import finite
from robolaser.data.importers.importer import ImportOptions
from robolaser.data.importers.ros_bag import JOINT_TOPIC, RosBag
from robolaser.data.importers.ros_messages import ARRAY, CONTROLLER, JOINTS, STAMPS, Bag, JointTrack
from robolaser.data.importers.table_files import ARRAY_FILES, SEPARATORS, read_arrays, read_delimited
from robolaser.errors import DataError, near
from robolaser.motion.log import PAUSE_S
from robolaser.robot.kinematics import Robot

TABLES: Final = (".csv", ".txt")
SERIES: Final = "series"
RTDE: Final = {
    "command": ("target_q",),
    "q": ("actual_q",),
    "qd": ("actual_qd",),
    "tau": ("actual_current_as_torque", "actual_current"),
}
"""Names of the outputs of Universal Robots' controller, each with the number of a joint."""
CURRENT: Final = "actual_current"
COMMAND_TOPIC: Final = "commands"


@final
@dataclass(frozen=True, eq=False)
class RecordedRun:
    """Columns by name, (n,) each, of numbers or of texts, with the units that their recorder states."""

    series: str
    source: str
    columns: Mapping[str, Array]
    time_unit: str = "s"
    angle_unit: str = ""  # "": not stated
    torque_unit: str = "Nm"
    torque_signed: bool = True

    def numbers(self, name: str, count: int | None = None) -> Array:
        """A column of numbers, NaN where a cell is empty.

        Raises:
            DataError: There is none of that name, its rows are not so many, or a cell is no number.
        """
        if name not in self.columns:
            raise self.lacks(name)
        values = self.columns[name]
        if count is not None and len(values) != count:
            raise DataError(f"{self.source}, column {name}: it has not as many rows as there are times.")
        if values.dtype.kind != "U":
            return values
        for row, cell in enumerate(values.tolist(), 1):
            if not _is_number(cell):
                where = f"column {name}, row {row} of series '{self.series}'"
                raise DataError(f"{self.source}, {where}: {cell!r}, expected a number, or nothing.", file=self.source)
        return np.array(list(map(finite, values.tolist())))

    def lacks(self, name: str) -> DataError:
        """The error where there is no column of a name."""
        return DataError(f"{self.source} has no column '{name}'.{near(name, self.columns)}")


@final
class Feature(msgspec.Struct):
    """A column in LeRobot's meta/info.json."""

    names: list[str] | dict[str, list[str]] | None = None


@final
class Features(msgspec.Struct):
    """The columns that are read."""

    action: Feature = msgspec.field(default_factory=Feature)
    state: Feature = msgspec.field(name="observation.state", default_factory=Feature)


@final
class LeRobotInfo(msgspec.Struct):
    """The keys of LeRobot's meta/info.json that are read."""

    features: Features = msgspec.field(default_factory=Features)


def runs_of(source: Path, robot: Robot, options: ImportOptions) -> list[RecordedRun]:
    """Read the runs of a folder or a file.

    Raises:
        DataError: Its kind is unknown, or it cannot be read.
        UsageError: It needs a library that is not installed, or the separator of its cells or the topic is ambiguous.
    """
    if RosBag().recognises(source):
        return _bag(source, robot, options.further)
    if source.is_dir():
        try:
            return _folder(source)
        except (LookupError, ValueError, msgspec.ValidationError, csv.Error) as error:
            reason = f"it lacks {error}" if isinstance(error, KeyError) else str(error)
            raise DataError(f"{source} is damaged, or not in its recorder's format: {reason}.", file=source) from None
    if source.suffix not in (*TABLES, *ARRAY_FILES):
        kinds = ", ".join((*TABLES, *ARRAY_FILES))
        raise DataError(f"{source.name}: a log of a moving arm is read from {kinds}, from a bag or from a folder.")
    columns = _table(source, options) if source.suffix in TABLES else _numbers(source)
    return _by_series(_named_by_rtde(RecordedRun(source.stem, source.name, columns)), options.columns.get(SERIES))


def _folder(source: Path) -> list[RecordedRun]:
    if (source / "meta" / "info.json").is_file():
        return _lerobot(source)
    folders = sorted({file.parent for file in source.rglob("control.csv")})
    found = [_sage(folder) for folder in folders if (folder / "state_motor.csv").is_file()]
    if found:
        return found
    raise DataError(
        f"{source} is neither a folder of SAGE (control.csv beside state_motor.csv) or LeRobot"
        " (meta/info.json) nor a bag of ROS."
    )


def _numbers(source: Path) -> dict[str, Array]:
    """The columns of a file of arrays."""
    return {name: each if each.dtype.kind == "U" else each.astype(float) for name, each in read_arrays(source).items()}


def _table(file: Path, options: ImportOptions) -> dict[str, Array]:
    header = (read_text(file).splitlines() or [""])[max(options.header_row, 1) - 1 :][:1]
    if options.separator is None and not any(sign in "".join(header) for sign in SEPARATORS):
        options = replace(options, separator="space")
    table = read_delimited(file, options)
    return {name: _cells([cell.replace(options.decimal, ".") for cell in table.cells(name)]) for name in table.columns}


def _is_number(cell: str) -> bool:
    return not cell.strip() or cell.strip().lower() == "nan" or bool(np.isfinite(finite(cell)))


def _cells(cells: Sequence[str]) -> Array:
    """Cells as numbers, NaN where one is empty; as texts if one is neither."""
    return np.array(list(map(finite, cells)) if all(map(_is_number, cells)) else cells)


def _by_series(run: RecordedRun, stated: str | None = None) -> list[RecordedRun]:
    """The runs of a table that names them, in a stated column or in one of the usual name."""
    key = stated or next((name for name in (SERIES, "episode_index") if name in run.columns), None)
    if key is None:
        return [run]
    if key not in run.columns:
        raise run.lacks(key)
    names = [one if isinstance(one, str) else f"{one:.15g}".replace("nan", "") for one in run.columns[key].tolist()]
    if not all(names):
        raise DataError(f"{run.source}, column {key}: row {names.index('') + 1} of the data names no series.")
    known = {column: each if len(each) == len(names) else each[:0] for column, each in run.columns.items()}
    of_row, parts = np.array(names), []
    for name in dict.fromkeys(names):
        own = of_row == name
        columns = {column: each[own] if len(each) else each for column, each in known.items()}
        parts.append(replace(run, series=f"{run.series}_{name}", columns=columns))
    return parts


def _named_by_rtde(run: RecordedRun) -> RecordedRun:
    """A table of Universal Robots' RTDE with the names of a log: NAME[i] for the joint i."""
    if "actual_q_0" not in run.columns:
        return run
    named, current = dict(run.columns), False
    for quantity, names in RTDE.items():
        name = next((name for name in names if f"{name}_0" in run.columns), None)
        if name is not None:
            current |= name == CURRENT
            numbered = [one for one in run.columns if one.rpartition("_")[0] == name]
            named |= {f"{quantity}[{one.rpartition('_')[2]}]": run.columns[one] for one in numbered}
    return replace(run, columns=named, angle_unit="rad", torque_unit="A" if current else run.torque_unit)


def _lerobot(folder: Path) -> list[RecordedRun]:
    """Versions 2 and 3: `action` and `observation.state` in the order of meta/info.json."""
    info = msgspec.convert(json.loads(read_text(folder / "meta" / "info.json")), LeRobotInfo)
    runs = []
    for file in sorted((folder / "data").rglob("*.parquet")):
        columns = _numbers(file)
        for key, quantity, feature in (
            ("action", "command", info.features.action), ("observation.state", "q", info.features.state),
        ):  # fmt: skip
            named = feature.names or []
            named = named.get("motors", []) if isinstance(named, dict) else named
            columns |= {
                f"{quantity}_{joint.removesuffix('.pos').removeprefix('main_')}": columns[f"{key}[{i}]"]
                for i, joint in enumerate(named)
                if f"{key}[{i}]" in columns
            }
        runs += _by_series(RecordedRun("episode", file.name, columns))
    return runs


def _sage(folder: Path) -> RecordedRun:
    """SAGE's collector: lists of joints in JSON, one stamp in microseconds for command and state."""
    joints = [line.strip() for line in read_text(folder / "joint_list.txt").splitlines() if line.strip()]
    control, state = (
        {row["timestamp"]: row for row in csv.DictReader(read_text(folder / name).splitlines())}
        for name in ("control.csv", "state_motor.csv")
    )
    stamps = [stamp for stamp in control if stamp in state]
    columns = {"timestamp": np.array([float(stamp or "") for stamp in stamps])}
    for quantity, table, field in (
        ("command", control, "positions"),
        ("q", state, "positions"),
        ("qd", state, "velocities"),
        ("tau", state, "torques"),
    ):
        lists = [msgspec.convert(json.loads(table[stamp][field] or ""), list[float | None]) for stamp in stamps]
        values = np.array(lists, dtype=np.float64)
        columns |= {f"{quantity}_{joint}": values[:, i] for i, joint in enumerate(joints)}
    return RecordedRun(folder.name, folder.name, columns, "us", "rad", torque_signed=False)


def _bag(source: Path, robot: Robot, stated: Mapping[str, str]) -> list[RecordedRun]:
    """The runs of a bag of ROS 1 or ROS 2: each reading of the joints, and the last command before it.

    Readings are joint states, or the feedback in a controller's state; commands are those of a controller's
    state, of joint states of another topic, or of an array in the robot's order. An array has no time stamp: then
    all times are those at which the messages were recorded. `joints` and `commands` in `stated` name the topics
    where there are several.
    """
    with Bag.opened([source], stated.get(STAMPS)) as bag:
        sent = stated.get(COMMAND_TOPIC)
        read = stated.get(JOINT_TOPIC)
        sent = sent or next(iter(bag.topics(ARRAY) or bag.topics(CONTROLLER)), None)
        if sent is not None and read is None:
            states = [topic for topic in bag.topics(JOINTS) if topic != sent]
            read = states[0] if len(states) == 1 else None
        read = bag.topic(JOINT_TOPIC, read or (None if bag.topics(JOINTS) else sent), JOINTS, CONTROLLER)
        timed = replace(bag, received=bag.received or sent in bag.topics(ARRAY))
        track = timed.joints(read, robot.joints)
        command = None if sent is None else timed.joints(sent, robot.joints, commanded=True)
    columns = {"time_s": track.time_s}
    for quantity, values in (("q", track.q), ("qd", track.qd), ("tau", track.effort)):
        if values is not None:
            columns |= {f"{quantity}_{joint}": values[:, j] for j, joint in enumerate(robot.joints)}
    if command is not None:
        columns |= {f"command_{joint}": each for joint, each in zip(robot.joints, _held(command, track).T, strict=True)}
    begins = np.flatnonzero(np.diff(track.time_s) > PAUSE_S) + 1
    parts = np.split(np.arange(len(track.time_s)), begins)
    return [
        RecordedRun(
            source.stem if len(parts) == 1 else f"{source.stem}_{number + 1}",
            source.name,
            {name: values[rows] for name, values in columns.items()},
            angle_unit="rad",
        )
        for number, rows in enumerate(parts)
    ]


def _held(command: JointTrack, track: JointTrack) -> Array:
    """The command that holds at each reading, (n, j); NaN before the first."""
    last = np.searchsorted(command.time_s, track.time_s, side="right") - 1
    return np.where((last >= 0)[:, None], command.q[np.maximum(last, 0)], np.nan)
