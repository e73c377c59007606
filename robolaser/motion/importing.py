"""Logs of moving arms that other programs wrote: SAGE's folders, LeRobot's data sets, tables and arrays."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import read_text
from robolaser.data.importers.array_files import ARRAY_FILES, read_arrays
from robolaser.data.importers.units import Units
from robolaser.errors import DataError, UsageError, near
from robolaser.geometry.units import ANGLE, FACTORS, LENGTH, TIME
from robolaser.motion.log import QUANTITIES, MotionLog
from robolaser.robot.kinematics import Robot

OTHER_NAMES: Final = {
    "shoulder_pan": "Rotation", "shoulder_lift": "Pitch", "elbow_flex": "Elbow", "wrist_flex": "Wrist_Pitch",
    "wrist_roll": "Wrist_Roll", "gripper": "Jaw",
}  # fmt: skip
"""What the SO-100's own program calls the joints of its URDF."""


@final
@dataclass(frozen=True, eq=False)
class _Run:
    """One file's columns by name, (n,) each, and what the file is like."""

    series: str
    source: str
    columns: Mapping[str, Array]
    time_unit: str = "s"
    angle_unit: str = ""  # "": the file does not say
    torque_signed: bool = True


@final
@dataclass(frozen=True, eq=False)
class ImportedMotion:
    """A log, and where each of its columns is from."""

    log: MotionLog
    read_from: Mapping[str, str]


def import_motion(
    sources: Sequence[Path], robot: Robot, columns: Mapping[str, str], units: Sequence[str], name: str
) -> ImportedMotion:
    """Read logs of one arm; each folder or file is a series, unless its rows say more.

    Args:
        sources: Folders of SAGE (control.csv beside state_motor.csv) or of LeRobot (meta/info.json), or tables and
            arrays: CSV, NPZ, MAT, Parquet.
        robot: The arm.
        columns: File's names by `time_s`, `series`, QUANTITY_JOINT, or a joint alone where a file names joints; of
            arrays NAME[i], or NAME for all joints in the robot's order.
        units: Of angles and times, where the files do not say them.
        name: Of the log.

    Raises:
        UsageError: A unit is not known, or not stated where the files do not say it.
        DataError: A file cannot be read, or holds no readings of the robot's joints.
    """
    stated = Units.of(units).stated
    if LENGTH in stated:
        raise UsageError(f"--units {stated[LENGTH]}: a log of a moving arm has angles and times, but no lengths.")
    runs = [run for source in sources for run in _runs(source)]
    read_from: dict[str, str] = {}
    parts: list[dict[str, Array]] = []
    labels: list[str] = []
    for run in runs:
        angle = run.angle_unit or stated.get(ANGLE, "")
        if not angle:
            raise UsageError(
                f"{run.source} does not say the unit of its angles: state --units rad or --units deg. Per cent of a"
                " range is no angle: have the recorder use degrees."
            )
        time = _column(run, columns.get("time_s", "time_s")) if "time_s" in columns else _time(run)
        part = {"time_s": (time - time[0]) * FACTORS[TIME][stated.get(TIME, run.time_unit)]}
        for quantity in QUANTITIES:
            values = np.full((len(time), len(robot.joints)), np.nan)
            for j, joint in enumerate(robot.joints):
                wanted = _wanted(run, quantity, joint, j, columns)
                if wanted is not None:
                    scale = 1.0 if quantity == "tau" else FACTORS[ANGLE][angle]
                    values[:, j] = scale * run.columns[wanted]
                    read_from[f"{quantity}_{joint}"] = f"{wanted} of {run.source}"
            part[quantity] = values
        parts.append(part)
        labels.append(run.series)
    if not any(np.isfinite(part["q"]).any() for part in parts):
        known = sorted({each for run in runs for each in run.columns})
        raise DataError(
            f"No column is the reading of a joint ({', '.join(robot.joints)}). The files have: {', '.join(known[:20])}."
            " Name one, such as --column q_JOINT=NAME."
        )
    names = tuple(dict.fromkeys(labels))
    counts = [len(part["time_s"]) for part in parts]
    number = np.repeat([names.index(label) for label in labels], counts).astype(np.int64)
    whole = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    order = np.argsort(number, kind="stable")
    at = {key: values[order] for key, values in whole.items()}
    log = MotionLog(
        name=name, robot=robot, series=names, run=number[order], time_s=at["time_s"], command=at["command"], q=at["q"],
        qd=at["qd"], tau=at["tau"], load=at["load"], torque_signed=all(run.torque_signed for run in runs),
    )  # fmt: skip
    return ImportedMotion(log, read_from)


def _runs(source: Path) -> list[_Run]:
    if not source.exists():
        raise DataError(f"{source} is not there.")
    if source.is_dir():
        if (source / "meta" / "info.json").is_file():
            return _lerobot(source)
        folders = sorted({file.parent for file in source.rglob("control.csv")})
        found = [_sage(folder) for folder in folders if (folder / "state_motor.csv").is_file()]
        if found:
            return found
        raise DataError(
            f"{source} is no folder of SAGE (control.csv beside state_motor.csv) nor of LeRobot (meta/info.json)."
        )
    if source.suffix != ".csv" and source.suffix not in ARRAY_FILES:
        kinds = ", ".join((".csv", *ARRAY_FILES))
        raise DataError(f"{source.name}: a log of a moving arm is read from {kinds}, or from a folder.")
    return _by_series(_Run(source.stem, source.name, _csv(source) if source.suffix == ".csv" else _numbers(source)))


def _numbers(source: Path) -> dict[str, Array]:
    """The columns of a file of arrays that are numbers."""
    return {name: each.astype(float) for name, each in read_arrays(source).items() if each.dtype.kind in "fiu"}


def _by_series(run: _Run) -> list[_Run]:
    """The runs of a table that numbers them."""
    key = next((name for name in ("series", "episode_index") if name in run.columns), None)
    if key is None:
        return [run]
    number = run.columns[key]
    return [
        _Run(f"{run.series}_{value:g}", run.source, {name: each[number == value] for name, each in run.columns.items()})
        for value in np.unique(number)
    ]


def _csv(file: Path) -> dict[str, Array]:
    rows = list(csv.DictReader(read_text(file).splitlines()))
    names = [name for name in (rows[0] if rows else {}) if name]
    found = {name: [row[name] for row in rows] for name in names}
    series = {value: i for i, value in enumerate(dict.fromkeys(found.get("series", ())))}
    return {
        name: np.array([series[cell] if name == "series" else _number(cell) for cell in cells])
        for name, cells in found.items()
    }


def _number(cell: str | None) -> float:
    try:
        return float(cell or "nan")
    except ValueError:
        return float("nan")


def _lerobot(folder: Path) -> list[_Run]:
    """Versions 2 and 3: `action` and `observation.state` in the order that meta/info.json names."""
    info = json.loads(read_text(folder / "meta" / "info.json"))
    runs = []
    for file in sorted((folder / "data").rglob("*.parquet")):
        columns = _numbers(file)
        for key, quantity in (("action", "command"), ("observation.state", "q")):
            named = info.get("features", {}).get(key, {}).get("names") or []
            named = named.get("motors", []) if isinstance(named, dict) else named
            for i, joint in enumerate(named):
                if f"{key}[{i}]" in columns:
                    columns[f"{quantity}_{str(joint).removesuffix('.pos').removeprefix('main_')}"] = columns[
                        f"{key}[{i}]"
                    ]
        runs += _by_series(_Run("episode", file.name, columns))
    return runs


def _sage(folder: Path) -> _Run:
    """SAGE's collector: lists of joints in JSON, one stamp in microseconds for command and state."""
    joints = [line.strip() for line in read_text(folder / "joint_list.txt").splitlines() if line.strip()]
    control, state = (
        {row["timestamp"]: row for row in csv.DictReader(read_text(folder / name).splitlines())}
        for name in ("control.csv", "state_motor.csv")
    )
    stamps = [stamp for stamp in control if stamp in state]
    columns = {"timestamp": np.array([float(stamp) for stamp in stamps])}
    parts = (
        ("command", control, "positions"),
        ("q", state, "positions"),
        ("qd", state, "velocities"),
        ("tau", state, "torques"),
    )
    for quantity, table, field in parts:
        values = np.array([json.loads(table[stamp][field]) for stamp in stamps], dtype=np.float64)
        columns |= {f"{quantity}_{joint}": values[:, i] for i, joint in enumerate(joints)}
    return _Run(folder.name, folder.name, columns, "us", "rad", torque_signed=False)


def _time(run: _Run) -> Array:
    for name in ("time_s", "timestamp", "time", "t"):
        if name in run.columns:
            return run.columns[name]
    raise DataError(
        f"{run.source} has no column time_s. Name it: --column time_s=NAME. It has {', '.join(run.columns)}."
    )


def _column(run: _Run, name: str) -> Array:
    if name not in run.columns:
        raise DataError(f"{run.source} has no column '{name}'.{near(name, run.columns)}")
    return run.columns[name]


def _wanted(run: _Run, quantity: str, joint: str, number: int, columns: Mapping[str, str]) -> str | None:
    """The column that holds a quantity of a joint."""
    own = f"{quantity}_{joint}"
    if own in columns:
        _column(run, columns[own])
        return columns[own]
    if quantity in columns:
        _column(run, f"{columns[quantity]}[{number}]")
        return f"{columns[quantity]}[{number}]"
    called = (columns.get(joint, joint), OTHER_NAMES.get(joint, joint))
    return next((f"{quantity}_{name}" for name in called if f"{quantity}_{name}" in run.columns), None)
