"""The writer of a recording: a complete data set is on the disk after every pose."""

import csv
import io
import os
import time
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self, final

import cv2
import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import read_text
from robolaser.cell.camera import Warn
from robolaser.cell.following import Tick
from robolaser.cell.quantization_noise import KEY, SECTION, quantization_rad, with_noise
from robolaser.cell.recovery import IMAGES, POSES, check_same_cell, pictured, same, whole_rows
from robolaser.cell.route import Waypoint, read_route, route_text
from robolaser.cell.setpoint_log import FILES as LOG_FILES
from robolaser.cell.setpoint_log import FOLDER as LOG_FOLDER
from robolaser.cell.setpoint_log import SetpointLog
from robolaser.data.atomic_write import clear_staged, naming, write_together
from robolaser.data.cell_config import FILE as CELL
from robolaser.data.cell_config import Cell
from robolaser.data.image_list import LIT, UNLIT
from robolaser.errors import DataError, OutputError, PlanError, output_exists
from robolaser.vision.board import Image

DATASET, PLAN = "dataset.toml", "plan.csv"
LEAST_PAUSE_S = 1.0
"""Between the last pose before an interruption and the first after it, where the disk's clock says less."""


@final
@dataclass(frozen=True, eq=False)
class Sample:
    """A configuration that the arm rested at.

    Attributes:
        name: Of the pose.
        time_s: Since the recording began [s].
        q: As read, (j,) [rad or m].
        images: By column of poses.csv; none where the arm only passed.
    """

    name: str
    time_s: float
    q: Array
    images: Mapping[str, Image] = field(default_factory=dict)


@final
class RecordingWriter:
    """The folder of a recording."""

    def __init__(self, cell: Cell, folder: Path, waypoints: Sequence[Waypoint], shots: int) -> None:
        self.folder = folder
        self.waypoints = tuple(waypoints)
        self.shots = shots
        self.time_s = 0.0
        """Since when the next entry counts from."""
        self.begun = False
        """Whether anything is on the disk."""
        self._cell = cell
        self._robot = cell.robot
        self._rows: list[dict[str, str]] = []
        self._tidy = True
        self._text: str | None = None
        self._log = SetpointLog(cell)

    @classmethod
    def begin(cls, cell: Cell, folder: Path, waypoints: Sequence[Waypoint], shots: int, *, force: bool) -> Self:
        """Begin a recording. Nothing is written before the first entry.

        Args:
            cell: Where it is taken.
            folder: Created if it does not exist.
            waypoints: The poses.
            shots: At each pose, with the laser on.
            force: Throw away a recording that is there.

        Raises:
            OutputError: There is one, or what is there is a cell, or lies in this one.
        """
        if (folder / CELL).exists() or folder.resolve().is_relative_to(cell.folder.resolve()):
            raise OutputError(f"{folder} is a cell or is inside one, and is not changed. Choose another --output.")
        writer = cls(cell, folder, waypoints, shots)
        there = [file for file in writer._files() if file.exists()]
        if there and not force:
            raise output_exists(there[0])
        return writer

    @classmethod
    def resume(cls, cell: Cell, folder: Path, waypoints: Sequence[Waypoint] | None, shots: int | None) -> Self:
        """Go on with a recording that was interrupted. What an interruption left half done is done again.

        Nothing is written before the first entry.

        Args:
            cell: Where it is taken.
            folder: Of the recording.
            waypoints: The poses; None: those it was begun with.
            shots: Likewise.

        Raises:
            DataError: None was begun there, or it was begun in another cell.
            PlanError: It was begun with other poses or shots.
        """
        if not (folder / PLAN).is_file():
            raise DataError(
                f"{folder} has no plan.csv, so no recording was begun there. Begin one without --resume.",
                file=folder / PLAN,
            )
        planned, planned_shots = read_route(folder / PLAN, cell.robot)
        if shots is not None and shots != planned_shots:
            raise _another_plan(folder, f"{planned_shots} shots a pose, not {shots}")
        if waypoints is not None and not same(waypoints, planned):
            raise _another_plan(folder, f"its {len(planned)} poses are not the {len(waypoints)} of this one")
        writer = cls(cell, folder, planned, planned_shots)
        writer.begun, writer._tidy = True, False
        if (folder / DATASET).is_file():
            check_same_cell(folder, DATASET, cell)
        if (folder / POSES).is_file():
            writer._take_up(folder / POSES)
        return writer

    @property
    def remaining(self) -> tuple[Waypoint, ...]:
        """Poses that are still to be visited."""
        done = {row["pose"] for row in self._rows if row.get("image")}
        return tuple(waypoint for waypoint in self.waypoints if waypoint.name not in done)

    @property
    def done(self) -> int:
        """How many poses are on the disk."""
        return len(self.waypoints) - len(self.remaining)

    @property
    def files(self) -> list[str]:
        """Names of what will be written to the folder or cleared away there."""
        stems, shots = map(self._stem, (one.name for one in self.remaining)), self._columns()
        images = [f"{IMAGES}/{stem}{_ending(shot)}" for stem in stems for shot in shots if shot.startswith(LIT)]
        if self.begun:
            return images
        urdf = tomllib.loads(read_text(self._cell.folder / DATASET))["robot"]["urdf"]
        return [
            *self._there(),
            *(str(file.relative_to(self.folder)) for file in self._files()),
            *([urdf] if (self._cell.folder / urdf).is_file() else []),
            *images,
        ]

    def unused(self, name: str) -> str:
        """A name that no pose bears: the one given, or with a number after it."""
        taken = {row["pose"] for row in self._rows} | {waypoint.name for waypoint in self.waypoints}
        number = 1
        while (free := name if number == 1 else f"{name}_{number}") in taken:
            number += 1
        return free

    @property
    def last_position(self) -> Array | None:
        """Where the arm last was, as far as the disk knows, (j,) [rad or m]; None: nowhere yet."""
        if not self._rows:
            return None
        return np.array([float(self._rows[-1][f"q_{joint}"]) for joint in self._robot.joints])

    def state_quantization_noise(self, step: Array, warn: Warn) -> None:
        """Let the recording state how finely joints were read, unless its cell states a noise of readings.

        Args:
            step: The smallest difference of angles that the arm can tell, (j,) [rad or m].
            warn: Is told where there is no room for it.
        """
        self._log.step_rad = float(step.max())
        if self.begun and (self.folder / DATASET).exists():
            return
        noise_rad = quantization_rad(step, self._robot)
        self._text = with_noise(read_text(self._cell.folder / DATASET), noise_rad)
        if self._text is None:
            warn(f"dataset.toml: [{SECTION}] has no room for {KEY} = {noise_rad:.2g}, how finely joints were read.")

    def add(self, samples: Sequence[Sample], ticks: Sequence[Tick] = ()) -> None:
        """Write where the arm was: the images first, last the table that names them.

        Args:
            samples: The last one names the series of the motion.
            ticks: The motion there, of an arm that follows setpoints.

        Raises:
            OutputError: The disk is full; the recording is as it was before.
        """
        described = self.begun and (self.folder / DATASET).exists()
        description = {} if described else self._description()
        files: dict[Path, bytes] = {}
        cleared: list[str] = []
        if not self.begun:
            with naming(self.folder):
                (self.folder / IMAGES).mkdir(parents=True, exist_ok=True)
            files[self.folder / PLAN] = route_text(self._robot, self.waypoints, self.shots).encode()
            cleared = self._there()
        if not self._tidy:
            self._tidy_up()
        rows = list(self._rows)
        for sample in samples:
            row = {"pose": sample.name, "time_s": f"{sample.time_s:.3f}"}
            row |= {f"q_{joint}": repr(float(q)) for joint, q in zip(self._robot.joints, sample.q, strict=True)}
            for column, image in sample.images.items():
                path = f"{IMAGES}/{self._stem(sample.name)}{_ending(column)}"
                files[self.folder / path] = cv2.imencode(".png", image)[1].tobytes()
                row[column] = path
            rows.append(row)
        if ticks:
            self._log.add(samples[-1].name, ticks)
            with naming(self.folder):
                (self.folder / LOG_FOLDER).mkdir(exist_ok=True)
            files |= {self.folder / name: data for name, data in self._log.files().items()}
        files |= {**description, self.folder / POSES: self._table(rows)}
        named = {str(file.relative_to(self.folder)): data for file, data in files.items()}
        write_together(self.folder, named, cleared)
        self._rows, self.begun = rows, True

    def _files(self) -> list[Path]:
        """Those that make a folder a recording, and what is extracted from one and no longer true of another."""
        return [self.folder / name for name in (DATASET, POSES, PLAN, "points.csv", "stripes.npy", *LOG_FILES)]

    def _there(self) -> list[str]:
        """Names of the files of a recording that is thrown away."""
        return [
            str(file.relative_to(self.folder)) for file in (*pictured(self.folder), *self._files()) if file.is_file()
        ]

    def _tidy_up(self) -> None:
        """Clear away what a power cut left of files."""
        with naming(self.folder):
            (self.folder / IMAGES).mkdir(exist_ok=True)
            clear_staged(self.folder)
            clear_staged(self.folder / IMAGES)
        self._tidy = True

    def _stem(self, name: str) -> str:
        """A file's name for a pose, whatever the pose is called; only a name of our own has a dot in it."""
        plain = name.replace("_", "").replace("-", "")
        number = next((i for i, waypoint in enumerate(self.waypoints) if waypoint.name == name), 0)
        return name if plain.isascii() and plain.isalnum() else f"visit.{number:04d}"

    def _columns(self) -> list[str]:
        switched = [UNLIT] if self._cell.laser_output is not None else []
        joints = [f"q_{joint}" for joint in self._robot.joints]
        return ["pose", "time_s", *joints, "image", *switched, *(f"image_{k}" for k in range(2, self.shots + 1))]

    def _table(self, rows: Sequence[Mapping[str, str]]) -> bytes:
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, self._columns(), restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue().encode()

    def _description(self) -> dict[Path, bytes]:
        """dataset.toml and the URDF that it names, as the cell has them; dataset.toml comes last."""
        text = self._text or read_text(self._cell.folder / DATASET)
        urdf = tomllib.loads(text)["robot"]["urdf"]
        files: dict[Path, bytes] = {}
        if (self._cell.folder / urdf).is_file():
            with naming(self.folder):
                (self.folder / urdf).parent.mkdir(parents=True, exist_ok=True)
            files[self.folder / urdf] = (self._cell.folder / urdf).read_bytes()
        return {**files, self.folder / DATASET: text.encode()}

    def _take_up(self, table: Path) -> None:
        """Read the rows that are whole and whose images are; the others' poses are visited again."""
        self._rows = whole_rows(table, self._columns())
        self.time_s = max([0.0, *(float(row["time_s"]) for row in self._rows)])
        again = {name for waypoint in self.remaining for name in waypoint.approach_names}
        self._rows = [row for row in self._rows if row["pose"] not in again]
        pause_s = time.time() - os.stat(table).st_mtime
        self.time_s += max(LEAST_PAUSE_S, pause_s)
        self._log.take_up(self.folder, {row["pose"] for row in self._rows})


def _ending(column: str) -> str:
    """image: .png, image_2: .2.png, image_off: .off.png."""
    return f"{column.removeprefix('image').replace('_', '.')}.png"


def _another_plan(folder: Path, what: str) -> PlanError:
    return PlanError(
        f"{folder} was begun with another plan: {what}. Continue with --resume alone, which keeps to that plan,"
        " or choose another --output."
    )
