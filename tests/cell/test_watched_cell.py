"""The whole emulated cell: an arm on a pseudo terminal, a laser on its output, and a camera that watches its world."""

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from emulator_process import EmulatorProcess

import robolaser
from robolaser.cli import main
from robolaser.data.cell_config import load_cell
from robolaser.estimation import optimal_poses
from robolaser.vision.board import find_board

EXAMPLE = Path(__file__).parents[2] / "examples" / "cell"
HURRY = 20.0


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    folder = tmp_path / "cell"
    shutil.copytree(EXAMPLE, folder)
    said = (folder / "cell.toml").read_text()
    (folder / "cell.toml").write_text(said.replace("speed_rad_s = 0.3", "speed_rad_s = 0.8"))
    return folder


def record(cell: Path, out: Path, emulated: EmulatorProcess, *more: str) -> int:
    where = ["--port", emulated.arm, "--camera", str(emulated.camera)]
    return main(["record", str(cell), "--output", str(out), *where, "--move", *more])


def test_a_collision_on_the_way_costs_no_pose(cell, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(optimal_poses, "LEAST_CANDIDATES", 12)
    world, out = cell / "world.toml", tmp_path / "out"
    with EmulatorProcess(cell, world=world, time_scale=HURRY, faults=["impact:2@60"]) as emulated:
        assert record(cell, out, emulated, "--plan", "2", "--repeats", "2") == 1
    said = capsys.readouterr().err
    assert "IMPACT PROTECTION" in said
    assert "It is at joint_1" in said
    begun = robolaser.load(out)
    said = (cell / "cell.toml").read_text()
    (cell / "cell.toml").write_text(said.replace("[arm]\n", "[arm]\nhome = true\n"))
    with EmulatorProcess(cell, world=world, time_scale=2 * HURRY) as emulated:
        assert record(cell, out, emulated, "--resume") == 0
    poses = robolaser.load(out).poses
    assert poses.names[: len(begun.poses)] == begun.poses.names
    assert {"start", "stopped", "resumed", "p001", "p002"} == set(poses.names)
    board = load_cell(cell).description.board
    for i, image in enumerate(poses.image):
        if image:
            on, again, off = (
                cv2.imread(str(out / name), cv2.IMREAD_GRAYSCALE)
                for name in (image, poses.extra["image_2"][i], poses.extra["image_off"][i])
            )
            assert find_board(off, columns=board.columns, rows=board.rows) is not None
            light = np.subtract(on, off, dtype=np.int16)
            assert 100 < (light > 60).sum() < 0.05 * light.size  # one stripe, nothing else has changed
            assert np.abs(np.subtract(on, again, dtype=np.int16)).max() < 60
            assert not np.array_equal(on, again)
