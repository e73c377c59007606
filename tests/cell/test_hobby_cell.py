"""A hobby arm on a servo bus with a camera on its gripper, from the first pose to the corners of the board."""

import shutil
from pathlib import Path

import numpy as np
from emulator_process import EmulatorProcess

from robolaser.cli import main
from robolaser.data.loading import load

EXAMPLE = Path(__file__).parents[2] / "examples" / "so101-cell"
HURRY = 20.0
CORNERS = 8 * 5


def test_the_board_is_found_from_every_planned_pose(tmp_path: Path) -> None:
    cell, recording, points = tmp_path / "cell", tmp_path / "recording", tmp_path / "points"
    shutil.copytree(EXAMPLE, cell)
    with EmulatorProcess(cell, world=cell / "world.toml", time_scale=HURRY) as emulated:
        how = ["--plan", "4", "--port", emulated.arm, "--camera", str(emulated.camera), "--move"]
        assert main(["record", str(cell), "--output", str(recording), *how]) == 0
    assert main(["extract", str(recording), "--output", str(points)]) == 0
    found = load(points)
    assert found.kind == "camera"
    assert np.bincount(found.points.pose)[np.unique(found.points.pose)].tolist() == [CORNERS] * 4
