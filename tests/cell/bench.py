"""A test bench for cells: emulated controllers on a fake wire in virtual time, and a fake camera."""

import pkgutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from emulated_cell import cell_folder
from fake_ur import UrRig
from virtual_cell import Bench, Jumping

from robolaser.arrays import Array, Image
from robolaser.cell.arm import ARMS, Arm
from robolaser.cell.camera import no_more_images
from robolaser.cell.recording_writer import RecordingWriter
from robolaser.cell.route import Waypoint, numbered
from robolaser.cell.serial_line import SerialLine
from robolaser.cell.session import Session
from robolaser.cell.ur import UrArm
from robolaser.data.cell_config import Cell, load_cell
from robolaser.emulator.emulated_cell import controller_of


class Watched:
    """Observes the motors directly during the motions of an arm."""

    def __init__(self, rig: Bench, every_s: float) -> None:
        self._rig = rig
        self._every_s = every_s
        self._wait = rig.clock.wait
        self._segment = (rig.motor(), rig.motor())
        self.seen: list[tuple[float, Array]] = []
        self.strayed = 0.0
        """Largest deviation of any motor from the straight path [rad]."""
        rig.clock.wait = self._waited

    def goes(self, arm: Arm) -> None:
        """Record the checked path of each motion: from the motors' positions at its start to its goal."""
        go = arm.start_move

        def start_move(q: Array, seconds: float) -> None:
            self._segment = (self._rig.motor(), q)
            go(q, seconds)

        arm.start_move = start_move

    def fastest(self) -> float:
        """Highest speed of any motor between observations [rad/s]."""
        times, q = np.array([t for t, _ in self.seen]), np.array([q for _, q in self.seen])
        return float((np.abs(np.diff(q, axis=0)).max(axis=1) / np.diff(times)).max(initial=0.0))

    def _waited(self, seconds: float) -> None:
        self._wait(seconds)
        now = self._rig.clock.now()
        if not self.seen or now - self.seen[-1][0] >= self._every_s:
            q = self._rig.motor()
            self.seen.append((now, q))
            start, goal = self._segment
            way = goal - start
            share = np.clip((q - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
            self.strayed = max(self.strayed, float(np.abs(q - start - share * way).max()))


class Painted:
    """A camera of grey noise, with a bright line if the laser is on."""

    def __init__(self, bench: Bench, size: tuple[int, int], breaks_at: int | None = None) -> None:
        self._bench = bench
        self._clock = bench.clock
        self._size = size
        self._left = breaks_at
        self._rng = np.random.default_rng(3)

    def shot(self, settle_s: float) -> Image:
        self._clock.wait(settle_s + 0.1)
        if self._left is not None:
            self._left -= 1
            if self._left < 0:
                raise no_more_images("painted", "it was unplugged")
        image = self._rng.integers(20, 40, self._size[::-1], dtype=np.uint8)
        if self._bench.controller.outputs(self._clock.now()):
            image[3] = 200
        return image

    def close(self) -> None:
        """Nothing."""


def cell(tmp_path: Path, kind: str = "acl") -> Cell:
    """A cell with small images, high above the floor."""
    folder = cell_folder(tmp_path, kind)
    text = (folder / "dataset.toml").read_text()
    text = text.replace("width_px = 640", "width_px = 24").replace("height_px = 480", "height_px = 16")
    (folder / "dataset.toml").write_text(text)
    limits = (folder / "cell.toml").read_text().replace("floor_m = 0.02", "floor_m = -0.5")
    (folder / "cell.toml").write_text(limits)
    return load_cell(folder)


def bench_for(cell: Cell, faults: Sequence[str] = (), seed: int = 1) -> Any:
    """The counterpart of the cell's arm: a `Bench`, or a `UrRig` in place of a library."""
    if cell.arm.kind == "ur":
        return UrRig(cell, Jumping(), faults)
    return Bench(controller_of(cell), Jumping(), faults, seed, cell.arm.baud)


def kind_of(name: str) -> str:
    """The kind of an arm of `emulated_cell.ARMS`."""
    return "acl" if name == "er5plus" else name


def arm_on(bench: Bench | UrRig, cell: Cell) -> Arm:
    """The package's arm on a bench."""
    if isinstance(bench, UrRig):
        with pytest.MonkeyPatch.context() as patch:
            bench.plugged_in(patch)
            return UrArm.open(cell, bench.clock)
    line = SerialLine(bench, "bench", bench.clock)
    arm: Arm = pkgutil.resolve_name(ARMS[cell.arm.kind])(line, cell.arm, cell.robot)
    return arm


def armed(cell: Cell, faults: Sequence[str] = (), seed: int = 1) -> tuple[Any, Arm]:
    """A bench, and the package's arm on it."""
    rig = bench_for(cell, faults, seed)
    return rig, arm_on(rig, cell)


def at_home(cell: Cell, home: bool) -> Cell:
    """The same cell with this setting of `home`."""
    return replace(cell, arm=replace(cell.arm, home=home))


def poses(cell: Cell, count: int) -> tuple[Waypoint, ...]:
    """Poses near home within all limits."""
    home = controller_of(cell).motor(0.0)
    return numbered(home + np.random.default_rng(8).uniform(-0.15, 0.15, (count, len(home))))


def session(
    cell: Cell, bench: Bench, writer: RecordingWriter, camera: Any = None, *, position_confirmed: bool = False
) -> Session:
    """A recording on the bench, ready to run."""
    eye = camera or Painted(bench, cell.description.image_px)
    arm = arm_on(bench, cell)
    return Session(cell, arm, eye, writer, bench.clock, lambda text: None, position_confirmed=position_confirmed)


def begun(cell: Cell, folder: Path, waypoints: Sequence[Waypoint], shots: int = 1) -> RecordingWriter:
    """A new recording."""
    return RecordingWriter(cell, folder, waypoints, shots)


def resumed(cell: Cell, folder: Path) -> RecordingWriter:
    """The resumed recording of a folder."""
    return RecordingWriter.resume(cell, folder, None, None)
