"""A log of a moving arm read from its folder, and written to one."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import SETTINGS_BYTES, parse_toml, read_text
from robolaser.data.csv_tables import CsvTable, bad_cell, finite, read_table, table_text
from robolaser.data.dataset_file import FILE, FORMAT, RobotTable, read_robot
from robolaser.data.toml_schema import NotNegative, Positive, read_toml, typed
from robolaser.data.writing import robot_table, toml_text
from robolaser.errors import DataError, near
from robolaser.motion.effect import MOVES_RAD
from robolaser.motion.log import OTHER_UNIT, PAUSE_S, QUANTITIES, MotionLog

MOTION = "motion.csv"
MOTION_FOLDER = ("dataset.toml", MOTION, "robot.urdf")
FEWEST_ROWS = 20
ODD_ANGLE = 4.0 * np.pi


@final
@dataclass(frozen=True)
class MotionSensorTable:
    """`[sensor]`."""

    kind: str


@final
@dataclass(frozen=True)
class MotionTable:
    """`[motion]`; further keys are notes."""

    torque_unit: Literal["Nm", "A"] = "Nm"
    torque_signed: bool = True
    offset_per_series: bool = False
    encoder_step_rad: Positive | None = None
    payload_kg: dict[str, NotNegative] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class MotionFile:
    """dataset.toml of a log."""

    format: str
    robot: RobotTable
    sensor: MotionSensorTable
    name: str = ""
    source: str = ""
    licence: str = ""
    motion: dict[str, Any] = field(default_factory=dict)


def is_motion(folder: str | Path) -> bool:
    """Whether a folder's dataset.toml declares a log of a moving arm; False where it cannot be read."""
    file = Path(folder) / FILE
    if not file.is_file():
        return False
    try:
        sensor = parse_toml(read_text(file, SETTINGS_BYTES)).get("sensor")
    except (ValueError, DataError):
        return False
    return isinstance(sensor, dict) and sensor.get("kind") == "motion"


def load_motion(folder: str | Path, *, planned: bool = False) -> MotionLog:
    """Read and check the log in a folder; of a planned one, commands without readings are sufficient.

    Raises:
        DataError: Names file, row and column of the fault.
        RobotError: The URDF, its flange or its joints are not usable.
    """
    folder = Path(folder)
    described = typed(read_toml(folder / FILE, FORMAT), MotionFile, file=FILE)
    known = {key: value for key, value in described.motion.items() if key in MotionTable.__annotations__}
    table = typed(known, MotionTable, file=FILE, at=("motion",))
    robot = read_robot(described.robot, folder)
    names = [f"{quantity}_{joint}" for quantity in QUANTITIES for joint in robot.joints]
    try:
        csv = read_table(folder / MOTION, ["time_s", *names])
    except DataError as error:
        if error.column not in names:
            raise
        csv = read_table(folder / MOTION, ["time_s"])  # some cells are empty
    odd = [name for name in csv.columns if name not in (*names, "series", "time_s")]
    warnings = [f"{MOTION}: column '{name}' is not used.{near(name, names)}" for name in odd]
    series = csv.texts("series")
    labels = tuple(dict.fromkeys(series))
    number = {name: i for i, name in enumerate(labels)}
    run = np.array([number[name] for name in series], dtype=np.int64)
    order = np.argsort(run, kind="stable")
    time_s = csv.numbers(["time_s"])[:, 0]
    recorded: dict[str, Any] = {
        quantity: _values(csv, [f"{quantity}_{joint}" for joint in robot.joints])[order] for quantity in QUANTITIES
    }
    log = MotionLog(
        name=described.name or folder.resolve().name, robot=robot, series=labels, run=run[order], time_s=time_s[order],
        notes={key: v for key, v in described.motion.items() if key not in known},
        source=described.source, licence=described.licence, **recorded, **asdict(table),
    )  # fmt: skip
    for name in table.payload_kg:
        if name not in labels:
            raise DataError(f"{FILE}, [motion] payload_kg: there is no series '{name}'.{near(name, labels)}", file=FILE)
    log, repeated = _in_order(log, np.array(csv.lines)[order])
    begins = np.array([rows.start for rows in log.rows_of_runs])
    log = replace(log, time_s=log.time_s - log.time_s[begins][log.run])
    return replace(log, warnings=(*warnings, *repeated, *_checked(log, planned=planned)))


def _values(csv: CsvTable, columns: Sequence[str]) -> Array:
    """Columns as numbers, (n, j); NaN where a cell is empty or a column is missing."""
    out = np.full((len(csv), len(columns)), np.nan)
    for j, column in enumerate(columns):
        cells = csv.columns.get(column, ())
        if not isinstance(cells, tuple):
            out[:, j] = cells
        else:
            for i, cell in enumerate(cells):
                if cell:
                    out[i, j] = finite(cell)
                    if not np.isfinite(out[i, j]):
                        raise bad_cell(MOTION, csv.lines[i], column, cell, "a finite number, or nothing")
    return out


def _in_order(log: MotionLog, lines: Array) -> tuple[MotionLog, list[str]]:
    """The log without rows that repeat a time stamp, and warnings."""
    step = np.diff(log.time_s)
    same = np.diff(log.run) == 0
    back = np.flatnonzero(same & (step < 0))
    if len(back):
        row = int(lines[back[0] + 1])
        raise DataError(
            f"{MOTION}, row {row}, column time_s: {log.time_s[back[0] + 1]:.6g} is before the row above, in series"
            f" '{log.series[log.run[back[0]]]}'. Sort the rows of each series by time, or give its parts names of their"
            " own.",
            file=MOTION, row=row, column="time_s",
        )  # fmt: skip
    again = np.concatenate([[False], same & (step == 0)])
    if not again.any():
        return log, []
    return log.of_rows(~again), [
        f"{MOTION}: {int(again.sum())} rows repeat the time stamp above them, and are left out."
    ]


def _checked(log: MotionLog, *, planned: bool) -> list[str]:
    if len(log) < FEWEST_ROWS:
        rows = f"{len(log)} row{'s' * (len(log) != 1)}"
        raise DataError(f"{MOTION} has {rows}: at least {FEWEST_ROWS} are needed.", file=MOTION)
    if not (planned or log.has("q").any()):
        raise DataError(
            f"{MOTION} has no column q_<joint> with readings of a joint of [robot]: {', '.join(log.joints)}.",
            file=MOTION,
        )
    if log.step_s > PAUSE_S:
        raise DataError(
            f"{MOTION}, column time_s: rows are {log.step_s:.4g} s apart. Are these milliseconds? Give seconds.",
            file=MOTION, column="time_s",
        )  # fmt: skip
    warnings: list[str] = []
    for joint, name in enumerate(log.joints):
        for quantity in ("command", "q", "load"):
            values = getattr(log, quantity)[:, joint]
            if np.nanmax(np.abs(values), initial=0.0) > ODD_ANGLE:
                raise DataError(
                    f"{MOTION}, column {quantity}_{name}: {np.nanmax(np.abs(values)):.4g} rad is more than two turns."
                    " Are these degrees, or encoder steps? Give radians.", file=MOTION, column=f"{quantity}_{name}",
                )  # fmt: skip
        warnings += _odd_readings(name, log.command[:, joint], log.q[:, joint])
    return warnings


def _odd_readings(name: str, command: Array, q: Array) -> Iterator[str]:
    """Warnings on readings of a joint (n,) that are unlikely for its commands (n,)."""
    both = np.isfinite(command) & np.isfinite(q)
    sent, read = command[both], q[both]
    if both.sum() < 2 or np.std(sent) < MOVES_RAD:
        return
    if np.array_equal(sent, read):
        yield f"The readings of {name} are its commands, digit by digit: they were not measured."
        return
    if np.std(read) < MOVES_RAD:
        yield f"{name} does not move, though it is commanded to."
        return
    factor = float(np.cov(sent, read)[0, 1] / np.var(sent))
    if factor < 0.0:
        yield (
            f"{name} moves by {factor:.3g} of what it is commanded: are the sign of its readings and the order of the"
            " joints right?"
        )
    elif not 1.0 / OTHER_UNIT < factor < OTHER_UNIT:
        degrees = " The factor is that from degrees to radians." if abs(np.log(np.degrees(factor))) < 0.2 else ""
        yield f"{name} moves by {factor:.3g} of what it is commanded: are commands and readings of one unit?{degrees}"


def motion_texts(log: MotionLog) -> dict[str, str]:
    """The contents of its files, by name; `load_motion` reads the same log back."""
    columns = {
        f"{quantity}_{joint}": getattr(log, quantity)[:, j]
        for j, joint in enumerate(log.joints)
        for quantity in QUANTITIES
        if log.has(quantity)[j]
    }
    cells = [["" if not np.isfinite(value) else f"{value:.10g}" for value in column] for column in columns.values()]
    names = (log.series[run] for run in log.run)
    rows = zip(names, (f"{time:.9g}" for time in log.time_s), *cells, strict=True)
    stated = {key: getattr(log, key) for key in MotionTable.__annotations__}
    described: dict[str, dict[str, object]] = {
        "": {"format": FORMAT, "name": log.name, "source": log.source, "licence": log.licence},
        "[robot]": robot_table(log.robot),
        "[sensor]": {"kind": "motion"},
        "[motion]": {**stated, **log.notes},
    }
    return {
        "robot.urdf": log.robot.urdf,
        MOTION: table_text(["series", "time_s", *columns], rows),
        "dataset.toml": toml_text(described.items()),
    }
