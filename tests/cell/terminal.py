"""An emulated arm in virtual time, and a camera that shows noise."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bench
import numpy as np
import pytest
from virtual_cell import in_virtual_time

import robolaser
from robolaser.arrays import Image
from robolaser.cli import main
from robolaser.emulator.emulated_cell import controller_of


class Shown:
    """A camera of noise, with a stripe in every other image, or in all of them."""

    def __init__(self, *, always: bool) -> None:
        self._rng, self._number, self._always = np.random.default_rng(1), 0, always

    def shot(self, settle_s: float) -> Image:
        image = self._rng.integers(30, 60, (16, 24), dtype=np.uint8)
        image[5] = 200 if self._always or self._number % 2 == 0 else 50
        self._number += 1
        return image

    def close(self) -> None:
        """Nothing."""


def recorded(words: Sequence[str], *, always: bool = False) -> int:
    """Run `robolaser record` with a camera of noise."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robolaser.cell.camera.open_camera", lambda *_: Shown(always=always))
        return main(["record", *words])


class Rig:
    """A cell with an emulated arm and a camera of noise."""

    def __init__(self, tmp_path: Path, kind: str) -> None:
        self.cell = bench.cell(tmp_path, kind)
        self.folder = self.cell.folder
        self.out = tmp_path / "recording"
        rng = np.random.default_rng(1)
        text = (self.folder / "cell.toml").read_text().replace("settle_s = 0.3", "settle_s = 0.01")
        (self.folder / "cell.toml").write_text(text.replace("speed_rad_s = 0.3", "speed_rad_s = 1.0"))
        home = controller_of(self.cell).motor(0.0)
        q = home + rng.uniform(-0.1, 0.1, (3, len(home)))
        self.poses = tmp_path / "poses.csv"
        header = ",".join(["pose", *(f"q_joint_{i}" for i in range(1, 6))])
        rows = [",".join([name, *map(repr, row.tolist())]) for name, row in zip("abc", q, strict=True)]
        self.poses.write_text("\n".join([header, *rows]) + "\n")

    def record(self, *more: str, port: str) -> int:
        words = [str(self.folder), "--output", str(self.out), "--port", port, *more]
        return recorded(words, always=self.cell.arm.kind == "lss")

    def home_first(self) -> None:
        text = (self.folder / "cell.toml").read_text()
        (self.folder / "cell.toml").write_text(text.replace("[arm]\n", "[arm]\nhome = true\n"))

    def names(self) -> list[str]:
        poses = robolaser.load(self.out).poses
        return [name for name, image in zip(poses.names, poses.image or (), strict=True) if image]


@contextmanager
def emulated(rig: Rig, *faults: str) -> Iterator[str]:
    """The cell's arm, in virtual time."""
    with in_virtual_time(rig.folder, faults=faults):
        yield "bench"
