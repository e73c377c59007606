"""The writer of a recording: a complete data set is on the disk after every pose, and can be resumed from there."""

import os
import re
import time
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self, final

import cv2
import numpy as np

from robolaser.arrays import Array, Image
from robolaser.bounded_reading import IMAGE_BYTES, read_bytes, read_text
from robolaser.cell.camera import Warn
from robolaser.cell.following import LOG_FILES, SetpointLog, Tick
from robolaser.cell.route import Waypoint, from_table, route_text
from robolaser.data.cell_config import Cell
from robolaser.data.csv_tables import CsvTable, read_table, table_text
from robolaser.data.image_list import LIT, UNLIT
from robolaser.data.result_folder import make_folder, write_together
from robolaser.data.toml_schema import read_toml
from robolaser.errors import DataError, PlanError
from robolaser.robot.kinematics import Robot

DATASET, POSES, PLAN, IMAGES = "dataset.toml", "poses.csv", "plan.csv", "images"
FILES = (DATASET, POSES, PLAN, "points.csv", "stripes.npy", *LOG_FILES)
"""The files of a recording, and those extracted from one, which a new recording makes invalid."""
LEAST_PAUSE_S = 1.0  # least pause between the poses around an interruption, if file times differ by less
MERE_WORDS = ("name", "source", "licence")
SECTION, KEY = "noise", "joint_rad"
HEADER = re.compile(r"^[ \t]*\[[ \t]*[\"']?noise[\"']?[ \t]*\].*$", re.MULTILINE)
PNG_BEGINS, PNG_ENDS = b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"


@final
@dataclass(frozen=True, eq=False)
class Sample:
    """A recorded configuration."""

    name: str  # of the pose
    time_s: float  # since the recording began
    q: Array  # reading, (j,) [rad or m]
    images: Mapping[str, Image] = field(default_factory=dict)  # by column of poses.csv; none where the arm only passed
    qd: Array | None = None  # velocities of an arm that moves, (j,) [rad/s or m/s]; None: it rests


@final
class RecordingWriter:
    """The folder of a recording. Nothing is written before the first entry, which replaces an existing recording.

    There are no waypoints for an arm that is moved by others; `shots` are those at each pose, with the laser on.
    """

    def __init__(self, cell: Cell, folder: Path, waypoints: Sequence[Waypoint], shots: int) -> None:
        self.folder = folder
        self.waypoints = tuple(waypoints)
        self.shots = shots
        self.time_s = 0.0  # origin of the next entry's time
        self.begun = False  # whether anything is on the disk
        self._cell = cell
        self._robot = cell.robot
        self._rows: list[dict[str, str]] = []
        self._text: str | None = None
        self._log = SetpointLog(cell)

    @classmethod
    def resume(cls, cell: Cell, folder: Path, waypoints: Sequence[Waypoint] | None, shots: int | None) -> Self:
        """Resume an interrupted recording; poses whose images are missing or incomplete are visited again.

        Waypoints and shots that are None are those of its plan.

        Raises:
            DataError: None was begun there, or it was begun in another cell, or its table is broken.
            PlanError: It was begun with other poses or shots.
        """
        if not (folder / PLAN).is_file():
            raise DataError(
                f"{folder} has no plan.csv, so no recording was begun there. Begin one without --resume.",
                file=folder / PLAN,
            )
        planned = from_table(folder / PLAN, cell.robot)
        begun = read_table(folder / POSES) if (folder / POSES).is_file() else None
        shown = [] if begun is None else [column for column in begun.columns if column.startswith(LIT)]
        taken = len({*shown} - {UNLIT})
        if shots and taken not in (0, shots):
            raise _another_plan(folder, f"{taken} shots a pose, not {shots}")
        if waypoints is not None and route_text(cell.robot, waypoints) != route_text(cell.robot, planned):
            raise _another_plan(folder, f"its {len(planned)} poses are not the {len(waypoints)} of this one")
        writer = cls(cell, folder, planned, taken or shots or 1)
        writer.begun = True
        if (folder / DATASET).is_file():
            _check_same_cell(folder / DATASET, cell)
        if begun is not None:
            writer._take_up(begun)
        return writer

    @property
    def remaining(self) -> tuple[Waypoint, ...]:
        """Poses that are still to be visited."""
        done = {row["pose"] for row in self._rows if row.get("image")}
        return tuple(waypoint for waypoint in self.waypoints if waypoint.name not in done)

    @property
    def done(self) -> int:
        """Number of poses on the disk."""
        return len(self.waypoints) - len(self.remaining)

    @property
    def files(self) -> list[str]:
        """Names of files that will be written to the folder or removed from it."""
        stems, shots = map(self._stem, (one.name for one in self.remaining)), self._columns()
        images = [f"{IMAGES}/{stem}{_ending(shot)}" for stem in stems for shot in shots if shot.startswith(LIT)]
        return images if self.begun else [*_pictured(self.folder), *FILES, *self._description(), *images]

    def unused(self, name: str) -> str:
        """A name that no pose has: the given one, or one with a number appended."""
        taken = {row["pose"] for row in self._rows} | {waypoint.name for waypoint in self.waypoints}
        number = 1
        while (free := name if number == 1 else f"{name}_{number}") in taken:
            number += 1
        return free

    @property
    def last_position(self) -> Array | None:
        """The last recorded position of the arm, (j,) [rad or m]; None if there is none."""
        if not self._rows:
            return None
        return np.array([float(self._rows[-1][f"q_{joint}"]) for joint in self._robot.joints])

    def state_quantization_noise(self, step: Array, warn: Warn) -> None:
        """State the resolution of readings, (j,) [rad or m], as noise, unless the cell states a noise of readings."""
        self._log.step_rad = float(step.max())
        if self.begun and (self.folder / DATASET).exists():
            return
        noise_rad = quantization_rad(step, self._robot)
        self._text = with_noise(read_text(self._cell.folder / DATASET), noise_rad)
        if self._text is None:
            warn(f"dataset.toml: [{SECTION}] has no room for {KEY} = {noise_rad:.2g}, how finely joints were read.")

    def add(self, samples: Sequence[Sample], ticks: Sequence[Tick] = ()) -> None:
        """Write samples: the images first, then the table that names them. The last one names the motion of the ticks.

        A full disk is an OutputError, and leaves the recording unchanged.
        """
        cleared = () if self.begun else (*_pictured(self.folder), *FILES)
        planned = bool(self.waypoints) and not self.begun
        files = {PLAN: route_text(self._robot, self.waypoints).encode()} if planned else {}
        rows = list(self._rows)
        for sample in samples:
            row = {"pose": sample.name, "time_s": f"{sample.time_s:.3f}"}
            for what, values in (("q", sample.q), ("qd", sample.qd)):
                pairs = () if values is None else zip(self._robot.joints, values.tolist(), strict=True)
                row |= {f"{what}_{joint}": repr(value) for joint, value in pairs}
            for column, image in sample.images.items():
                row[column] = f"{IMAGES}/{self._stem(sample.name)}{_ending(column)}"
                files[row[column]] = cv2.imencode(".png", image)[1].tobytes()
            rows.append(row)
        if ticks:
            self._log.add(samples[-1].name, ticks)
            files |= self._log.files()
        if not (self.begun and (self.folder / DATASET).exists()):
            files |= self._description()
        columns = self._columns()
        files[POSES] = table_text(columns, [[row.get(name, "") for name in columns] for row in rows]).encode()
        for home in {(self.folder / name).parent for name in files}:
            make_folder(home)
        write_together(self.folder, files, cleared)
        self._rows, self.begun = rows, True

    def _stem(self, name: str) -> str:
        """A file name for a pose, whatever its name; only names given here have a dot."""
        plain = name.replace("_", "").replace("-", "")
        number = next((i for i, waypoint in enumerate(self.waypoints) if waypoint.name == name), 0)
        return name if plain.isascii() and plain.isalnum() else f"visit.{number:04d}"

    def _columns(self) -> list[str]:
        switched = [UNLIT] if self.waypoints and self._cell.laser_output is not None else []
        quantities = ("q",) if self.waypoints else ("q", "qd")  # an arm that is moved by others does not stop
        joints = [f"{what}_{joint}" for what in quantities for joint in self._robot.joints]
        return ["pose", "time_s", *joints, LIT, *switched, *(f"image_{k}" for k in range(2, self.shots + 1))]

    def _description(self) -> dict[str, bytes]:
        """dataset.toml and the URDF that it names, as the cell has them; dataset.toml comes last."""
        text = self._text or read_text(self._cell.folder / DATASET)
        urdf = tomllib.loads(text)["robot"]["urdf"]
        drawn = self._cell.folder / urdf
        return {**({urdf: drawn.read_bytes()} if drawn.is_file() else {}), DATASET: text.encode()}

    def _take_up(self, table: CsvTable) -> None:
        """Take the rows with complete images, if the columns are the current ones; other poses are visited again."""
        columns = self._columns()
        if differing := sorted(table.columns.keys() ^ set(columns)):
            what = f"its poses.csv and what would be recorded now differ in {', '.join(differing)}"
            raise _another_cell(self.folder, what)
        table.numbers([name for name in columns if name == "time_s" or name.startswith("q_")])
        rows = (dict(zip(columns, cells, strict=True)) for cells in zip(*map(table.cells, columns), strict=True))
        images = [name for name in columns if name.startswith(LIT)]
        self._rows = [row for row in rows if all(_is_whole(self.folder / row[name]) for name in images if row[name])]
        self.time_s = max([0.0, *(float(row["time_s"]) for row in self._rows)])
        again = {name for waypoint in self.remaining for name in waypoint.approach_names}
        self._rows = [row for row in self._rows if row["pose"] not in again]
        self.time_s += max(LEAST_PAUSE_S, time.time() - os.stat(self.folder / POSES).st_mtime)
        self._log.take_up(self.folder, {row["pose"] for row in self._rows})


def _ending(column: str) -> str:
    """image: .png, image_2: .2.png, image_off: .off.png."""
    return f"{column.removeprefix('image').replace('_', '.')}.png"


def _check_same_cell(file: Path, cell: Cell) -> None:
    """Check that a recording's dataset.toml is its cell's, except for the noise of readings that was added."""
    now, then = read_toml(cell.folder / file.name), read_toml(file)
    if KEY not in now.get(SECTION, {}):
        then.get(SECTION, {}).pop(KEY, None)
    keys = [key for key in {**then, **now} if key not in MERE_WORDS and then.get(key, {}) != now.get(key, {})]
    if keys:
        raise _another_cell(file.parent, f"its dataset.toml and the cell's differ in {', '.join(keys)}")


def _pictured(folder: Path) -> list[str]:
    """Names of the images that a recording has taken; none where its poses.csv cannot be read."""
    try:
        read = read_table(folder / POSES)
    except DataError:
        return []
    names = [name for column in read.columns if column.startswith("image") for name in read.cells(column)]
    return [name for name in names if name.startswith("images/") and ".." not in name and (folder / name).is_file()]


def _another_plan(folder: Path, what: str) -> PlanError:
    return PlanError(
        f"{folder} was begun with another plan: {what}. Continue with --resume alone, which keeps to that plan,"
        " or choose another --output."
    )


def _is_whole(image: Path) -> bool:
    """Whether a PNG file is complete."""
    try:
        data = read_bytes(image, IMAGE_BYTES)
    except DataError:
        return False
    return data.startswith(PNG_BEGINS) and data.endswith(PNG_ENDS)


def _another_cell(folder: Path, what: str) -> DataError:
    return DataError(
        f"{folder} was begun in another cell: {what}. Continue with the cell as it was, or choose another --output.",
        file=folder,
    )


def quantization_rad(step: Array, robot: Robot) -> float:
    """Standard deviation of readings rounded to steps, (j,) [rad or m], RMS over the revolute joints [rad]."""
    turning = step[~robot.prismatic]
    return float(np.sqrt(np.mean(turning**2) / 12.0)) if turning.size else 0.0


def with_noise(text: str, noise_rad: float) -> str | None:
    """dataset.toml with a standard deviation of readings [rad], unless it states one; None: [noise] has no header."""
    stated = tomllib.loads(text)
    if noise_rad == 0 or KEY in stated.get(SECTION, {}):
        return text
    line = f"{KEY} = {noise_rad:.2g}   # the steps of the arm's readings over the root of 12"
    if SECTION not in stated:
        return f"{text.rstrip()}\n\n[{SECTION}]\n{line}\n"
    new = HEADER.sub(rf"\g<0>\n{line}", text, count=1)
    return new if KEY in tomllib.loads(new)[SECTION] else None
