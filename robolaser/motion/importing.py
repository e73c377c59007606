"""Logs of moving arms from other programs: their columns as joints, in radians and seconds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import SETTINGS_BYTES, read_text
from robolaser.data.importers.importer import ImportOptions, stated_units
from robolaser.data.importers.ros_bag import JOINT_TOPIC
from robolaser.data.importers.ros_messages import STAMPS
from robolaser.data.lerobot import TURN, MotorCalibration, read_servos
from robolaser.errors import DataError, UsageError, near
from robolaser.geometry.units import ANGLE, FACTORS, LENGTH, TIME
from robolaser.motion.log import QUANTITIES, MotionLog
from robolaser.motion.recorders import COMMAND_TOPIC, SERIES, RecordedRun, runs_of
from robolaser.robot.kinematics import Robot

OTHER_NAMES: Final = {
    "shoulder_pan": "Rotation", "shoulder_lift": "Pitch", "elbow_flex": "Elbow", "wrist_flex": "Wrist_Pitch",
    "wrist_roll": "Wrist_Roll", "gripper": "Jaw",
}  # fmt: skip
"""Joint names in the SO-100's program, by those of its URDF."""
CALIBRATION, TORQUE_UNIT = "calibration", "torque_unit"
FURTHER: Final = (CALIBRATION, TORQUE_UNIT, JOINT_TOPIC, COMMAND_TOPIC, STAMPS)
"""Options by name: LeRobot's calibration file, the unit of torques, a bag's topics of readings and commands, and the
time of a message that counts."""
OF_SERVO: Final = ("percent", "ticks")  # units that need the calibration file of an arm
GRIPPER: Final = "gripper"  # the joint that LeRobot counts from 0 to 100 per cent; the others from -100 to 100


@final
@dataclass(frozen=True)
class _Angles:
    """Conversion of a file's numbers to radians."""

    unit: str  # "": it was not stated
    servos: Mapping[str, MotorCalibration]

    @classmethod
    def of(cls, units: Sequence[str], robot: Robot, further: Mapping[str, str]) -> tuple["_Angles", Mapping[str, str]]:
        """The stated unit of angles, and the other units."""
        of_servo = [unit for unit in units if unit in OF_SERVO]
        stated = stated_units([unit for unit in units if unit not in OF_SERVO])
        if LENGTH in stated:
            raise UsageError(f"--units {stated[LENGTH]}: a log of a moving arm has angles and times, but no lengths.")
        if not of_servo:
            return cls(stated.get(ANGLE, ""), {}), stated
        if len(of_servo) > 1 or ANGLE in stated:
            raise UsageError(f"--units: {', '.join(units)} has two units of angles: name one.")
        if CALIBRATION not in further:
            raise UsageError(
                f"--units {of_servo[0]}: only LeRobot's calibration file of the arm makes angles of these. Name it with"
                f" --set {CALIBRATION}=FILE."
            )
        file = Path(further[CALIBRATION])
        return cls(of_servo[0], read_servos(read_text(file, SETTINGS_BYTES), robot.joints, file.name)), stated

    def radians(self, values: Array, joint: str, unit: str, *, speed: bool) -> Array:
        """Numbers of a joint in the file's unit, or else the stated one, as radians or radians per second."""
        if unit or not self.servos:
            return FACTORS[ANGLE][unit or self.unit] * values
        servo = self.servos[joint]
        if self.unit == "ticks":
            return 2.0 * np.pi / TURN * (values - (0.0 if speed else servo.middle))
        half = (servo.range_max - servo.range_min) / 2.0 * 2.0 * np.pi / TURN
        counted = (2.0 * values - (0.0 if speed else 100.0)) if joint == GRIPPER else values
        return (-half if servo.drive_mode else half) * counted / 100.0


def import_motion(sources: Sequence[Path], robot: Robot, options: ImportOptions) -> tuple[MotionLog, dict[str, str]]:
    """Read logs of one arm; each folder or file is a series, unless its rows name several.

    Args:
        sources: Folders of SAGE (control.csv beside state_motor.csv) or of LeRobot (meta/info.json), bags of ROS, or
            tables and arrays: text, NPZ, MAT, Parquet.
        robot: The arm.
        options: `columns` are the file's names by `time_s`, `series`, QUANTITY_JOINT, or a joint alone where a file
            names joints; of arrays NAME[i], or NAME for all joints in the robot's order. `units` of angles and times,
            where the files do not state them. `further` has those of `FURTHER`.

    Returns:
        The log, and the source of each of its columns.

    Raises:
        UsageError: A unit or option is unknown, or missing where the files do not state it.
        DataError: A file cannot be read, or holds no readings of the robot's joints.
        DependencyMissing: A library that a file needs is not installed.
    """
    for name in options.further:
        if name not in FURTHER:
            raise UsageError(f"--set {name}: no option of logs of moving arms.{near(name, FURTHER)}")
    joints = (*robot.joints, *(f"{quantity}_{joint}" for quantity in QUANTITIES for joint in robot.joints))
    named = (SERIES, "time_s", *QUANTITIES, *joints)
    for name in options.columns:
        if name not in named:
            raise UsageError(f"--column {name}: no column of a log of this arm.{near(name, named)}")
    angles, stated = _Angles.of(options.units, robot, options.further)
    torque_unit = options.further.get(TORQUE_UNIT)
    if torque_unit not in (None, "Nm", "A"):
        raise UsageError(f"--set {TORQUE_UNIT}={torque_unit}: expected Nm or A.")
    runs = []
    for source in sources:
        if not source.exists():
            raise DataError(f"{source} is not there.")
        runs += runs_of(source, robot, options)
    read_from: dict[str, str] = {}
    parts: list[dict[str, Array]] = []
    for run in runs:
        if not (run.angle_unit or angles.unit):
            raise UsageError(
                f"{run.source} does not state the unit of its angles: state --units rad or --units deg; per cent of"
                f" joints' ranges with --units percent --set {CALIBRATION}=FILE."
            )
        parts.append(_part(run, robot, options.columns, angles, stated.get(TIME, run.time_unit), read_from))
    if not any(np.isfinite(part["q"]).any() for part in parts):
        known = sorted({each for run in runs for each in run.columns})
        raise DataError(
            f"No column is the reading of a joint ({', '.join(robot.joints)}). The files have: {', '.join(known[:20])}."
            " Name one, such as --column q_JOINT=NAME."
        )
    whole: dict[str, Any] = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    units = {run.torque_unit for run in runs}
    log = MotionLog(
        name=options.name, robot=robot, series=_distinct([run.series for run in runs]),
        run=np.repeat(np.arange(len(runs)), [len(part["time_s"]) for part in parts]),
        torque_unit=torque_unit or ("A" if "A" in units else "Nm"),
        torque_signed=all(run.torque_signed for run in runs), **whole,
    )  # fmt: skip
    return log, read_from


def _distinct(names: Sequence[str]) -> tuple[str, ...]:
    """Names with a number appended to repeated ones: files in several folders may share a name."""
    taken: dict[str, None] = {}
    for name in names:
        free, number = name, 1
        while free in taken:
            number += 1
            free = f"{name}_{number}"
        taken[free] = None
    return tuple(taken)


def _part(
    run: RecordedRun, robot: Robot, columns: Mapping[str, str], angles: _Angles, time_unit: str, sources: dict[str, str]
) -> dict[str, Array]:
    """The columns of a run; adds their sources."""
    time = run.numbers(columns["time_s"]) if "time_s" in columns else _time(run)
    if not len(time):
        raise DataError(f"{run.source}: series '{run.series}' has no times.", file=run.source)
    if not np.isfinite(time).all():
        row = int(np.argmin(np.isfinite(time))) + 1
        raise DataError(f"{run.source}: row {row} of series '{run.series}' has no time.", file=run.source)
    part = {"time_s": (time - time[0]) * FACTORS[TIME][time_unit]}
    for quantity in QUANTITIES:
        part[quantity] = values = np.full((len(time), len(robot.joints)), np.nan)
        for j, joint in enumerate(robot.joints):
            wanted = _wanted(run, quantity, joint, j, columns)
            if wanted is None:
                continue
            of_file = run.numbers(wanted, len(time))
            values[:, j] = (
                of_file if quantity == "tau" else angles.radians(of_file, joint, run.angle_unit, speed=quantity == "qd")
            )
            sources[f"{quantity}_{joint}"] = f"{wanted} of {run.source}"
    return part


def _time(run: RecordedRun) -> Array:
    for name in ("time_s", "timestamp", "time", "t"):
        if name in run.columns:
            return run.numbers(name)
    raise DataError(
        f"{run.source} has no column time_s. Name it: --column time_s=NAME. It has {', '.join(run.columns)}."
    )


def _wanted(run: RecordedRun, quantity: str, joint: str, number: int, columns: Mapping[str, str]) -> str | None:
    """The column that holds a quantity of a joint."""
    whole = f"{columns[quantity]}[{number}]" if quantity in columns else None
    if stated := columns.get(f"{quantity}_{joint}", whole):
        return stated
    called = (columns.get(joint, joint), OTHER_NAMES.get(joint, joint))
    names = (*(f"{quantity}_{name}" for name in called), f"{quantity}[{number}]")
    return next((name for name in names if name in run.columns), None)
