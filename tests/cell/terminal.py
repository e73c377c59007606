"""An emulated arm in virtual time, and pictures for a camera."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bench
import cv2
import numpy as np
from virtual_cell import in_virtual_time

import robolaser
from robolaser.cli import main
from robolaser.emulator.emulated_cell import controller_of

SHOTS = 40


class Rig:
    """A cell whose arm is emulated, and whose camera is a folder of pictures."""

    def __init__(self, tmp_path: Path, kind: str) -> None:
        self.cell = bench.cell(tmp_path, kind)
        self.folder = self.cell.folder
        self.out = tmp_path / "recording"
        self.pictures = tmp_path / "pictures"
        self.pictures.mkdir()
        rng = np.random.default_rng(1)
        for i in range(SHOTS):
            image = rng.integers(30, 60, (16, 24), dtype=np.uint8)
            image[5] = 200 if i % 2 == 0 or kind == "lss" else 50
            cv2.imwrite(str(self.pictures / f"{i:03d}.png"), image)
        said = (self.folder / "cell.toml").read_text()
        said = said.replace("tcp://127.0.0.1:5001", str(self.pictures)).replace("settle_s = 0.3", "settle_s = 0.01")
        (self.folder / "cell.toml").write_text(said.replace("speed_rad_s = 0.3", "speed_rad_s = 1.0"))
        home = controller_of(self.cell).motor(0.0)
        q = home + rng.uniform(-0.1, 0.1, (3, len(home)))
        self.poses = tmp_path / "poses.csv"
        header = ",".join(["pose", *(f"q_joint_{i}" for i in range(1, 6))])
        rows = [",".join([name, *map(repr, row.tolist())]) for name, row in zip("abc", q, strict=True)]
        self.poses.write_text("\n".join([header, *rows]) + "\n")

    def record(self, *more: str, port: str) -> int:
        return main(["record", str(self.folder), "--output", str(self.out), "--port", port, *more])

    def home_first(self) -> None:
        said = (self.folder / "cell.toml").read_text()
        (self.folder / "cell.toml").write_text(said.replace("[arm]\n", "[arm]\nhome = true\n"))

    def names(self) -> list[str]:
        poses = robolaser.load(self.out).poses
        return [name for name, image in zip(poses.names, poses.image or (), strict=True) if image]


@contextmanager
def emulated(rig: Rig, *faults: str) -> Iterator[str]:
    """The cell's arm, in virtual time."""
    with in_virtual_time(rig.folder, faults=faults):
        yield "bench"
