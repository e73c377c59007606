"""Trajectories in TUM's format: lines of time, place and quaternion."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import read_text
from robolaser.data.csv_tables import finite
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.importers.clock_offset import CLOCKS, Trajectory, by_one_clock
from robolaser.data.importers.importer import Imported, Importer, ImportOptions, Reading
from robolaser.data.importers.time_matching import TOLERANCE, match, tolerance_of, with_readings
from robolaser.data.importers.yaml_file import motion_of_seven, peek
from robolaser.data.pose_table import FLANGE_COLUMNS
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import to_quaternion

COLUMNS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
SUFFIXES = (".tum", ".txt")
BODY = "body"


@final
class Tum(Importer):
    """The flange's trajectory and then that of a body on it as a tracker saw it; or the flange's alone.

    The body's poses are kept, each with the flange's pose at its time, between the two readings around it.
    """

    name: ClassVar[str] = "tum"
    title: ClassVar[str] = "TUM trajectories (timestamp tx ty tz qx qy qz qw): the flange's, then a tracked body's"
    further: ClassVar[tuple[str, ...]] = (TOLERANCE, CLOCKS)
    takes: ClassVar[tuple[str, ...]] = ("point",)

    def recognises(self, path: Path) -> bool:
        """By its suffix and its first line of numbers."""
        return path.suffix.lower() in SUFFIXES and any(
            len(cells) == len(COLUMNS) and np.isfinite([finite(cell) for cell in cells]).all()
            for cells in islice(_rows(peek(path).splitlines()), 1)
        )

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read one trajectory or two."""
        if len(paths) > 2:
            raise UsageError(f"{len(paths)} trajectories: expected the flange's, and perhaps that of a tracked body.")
        flange, *others = [read_tum(path) for path in paths]
        repeated = _repeated([flange, *others])
        dataset = Dataset(
            options.name,
            _poses(flange.time_s, flange.T),
            Points(np.empty(0, dtype=np.int64), ()),
            kind="pose",
            path_known=options.path_known,
            source=", ".join(path.name for path in paths),
        )
        if not others:
            if options.further or options.point is not None:
                raise UsageError("One trajectory is the flange's: name that of the tracked body as a second file.")
            return Imported(dataset, tuple(_pose_readings(flange.file, flange.file, "")), repeated)
        tolerance = tolerance_of(options.further, others[0].file)
        body, clock, warnings = by_one_clock(flange, others[0], tolerance, options.further)
        found = match(flange.time_s, body.time_s, tolerance)
        kept, left_out = with_readings(found.near, found.away_s, tolerance, file=body.file, what="pose")
        name = options.point or BODY
        points = Points(
            np.arange(len(kept)),
            (name,) * len(kept),
            xyz=body.T[kept, :3, 3],
            columns={"quaternion": to_quaternion(body.T[kept, :3, :3])},
        )
        poses = _poses(body.time_s[kept], found.motions(flange.T)[kept])
        readings = [
            *_pose_readings(flange.file, body.file, f", at the times of {body.file}", clock),
            Reading("points.csv", "pose", body.file, "(number of the pose)"),
            Reading("points.csv", "point", body.file, "(--point)" if options.point else "(a name)"),
            *(Reading("points.csv", *pair) for pair in _columns(body.file, "")),
        ]
        dataset = replace(dataset, poses=poses, points=points, warnings=warnings)
        return Imported(dataset, tuple(readings), (*repeated, *left_out))


def read_tum(path: Path) -> Trajectory:
    """Read a trajectory, without lines that repeat the time of the one before.

    Raises:
        DataError: A line is not eight finite numbers, a quaternion's length is not one, or times are not in order.
    """
    text = read_text(path).splitlines()
    lines = [number for number, line in enumerate(text, 1) if line.split("#")[0].strip()]
    rows = np.empty((len(lines), len(COLUMNS)))
    T = np.empty((len(lines), 4, 4))
    for i, line in enumerate(lines):
        cells = [finite(cell) for cell in _cells(text[line - 1])]
        if len(cells) != len(COLUMNS) or not np.isfinite(cells).all():
            raise DataError(
                f"{path.name}, row {line}: expected eight numbers: {' '.join(COLUMNS)}.", file=path.name, row=line
            )
        rows[i] = cells
        T[i] = motion_of_seven(rows[i, 1:], path.name, f"row {line}")
    if not lines:
        raise DataError(f"{path.name} has no line of numbers: {' '.join(COLUMNS)}.", file=path.name)
    for i in np.flatnonzero(np.diff(rows[:, 0]) < 0)[:1]:
        raise DataError(
            f"{path.name}, row {lines[i + 1]}: its time is before that of the row before.",
            file=path.name,
            row=lines[i + 1],
            column=COLUMNS[0],
        )
    new = np.diff(rows[:, 0], prepend=-np.inf) > 0
    return Trajectory(path.name, rows[new, 0], T[new], int((~new).sum()))


def _repeated(trajectories: Sequence[Trajectory]) -> tuple[str, ...]:
    return tuple(
        f"{one.file}: {one.repeated} rows, whose times repeat the row before" for one in trajectories if one.repeated
    )


def _rows(lines: Sequence[str]) -> list[list[str]]:
    return [cells for line in lines if (cells := _cells(line))]


def _cells(line: str) -> list[str]:
    return line.split("#", maxsplit=1)[0].replace(",", " ").split()


def _poses(time_s: Array, T: Array) -> Poses:
    return Poses(tuple(str(i) for i in range(1, len(time_s) + 1)), time_s, T_base_flange=T)


def _pose_readings(file: str, timed: str, at: str, clock: str = "") -> list[Reading]:
    return [
        Reading("poses.csv", "pose", timed, "(number of the pose)"),
        Reading("poses.csv", "time_s", timed, f"{COLUMNS[0]}{clock}", "s"),
        *(Reading("poses.csv", *pair) for pair in _columns(file, at)),
    ]


def _columns(file: str, at: str) -> list[tuple[str, str, str, str]]:
    return [
        (column, file, f"{source}{at}", "m" if column.endswith("_m") else "")
        for column, source in zip(FLANGE_COLUMNS, COLUMNS[1:], strict=True)
    ]
