"""The page for owners of hobby arms does what it shows, from an empty folder, with an emulated arm."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from emulator_process import EmulatorProcess
from few_files import untried
from virtual_cell import in_virtual_time

sys.path.insert(0, str(Path(__file__).parents[1] / "docs"))

from run_code_blocks import blocks, commands, compare
from typed import run_typed

from robolaser.data.loading import load
from robolaser.emulator.servo_loop import SERVO_FAULTS
from robolaser.motion.reading import load_motion

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "howto" / "hobby-arm.md"
TRUTH = {("joint_offset", "elbow_flex"): 0.05, ("backlash", "shoulder_lift"): 0.01}
SERVOS = {
    ("dead_zone", "elbow_flex", "half_width"): 0.03,
    ("droop", "shoulder_lift", "compliance"): 0.05,
    ("droop", "elbow_flex", "compliance"): 0.08,
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all commands of the page were run; the recording takes no time."""
    folder = tmp_path_factory.mktemp("hobby")
    shutil.copytree(ROOT / "examples", folder / "examples")
    for block in blocks(PAGE.read_text(encoding="utf-8")):
        for command, shown in commands(block.body) if block.language == "console" else ():
            if command.startswith("robolaser emulate "):
                cell = folder / command.split()[2]
                with EmulatorProcess(cell, world=cell / "world.toml") as emulated:
                    assert emulated.camera
            elif command.startswith("robolaser record ") and command.endswith("--move"):
                with in_virtual_time(folder / command.split()[2]):
                    compare(shown, run_typed(command, folder, expected=0))
            else:
                with untried():
                    compare(shown, run_typed(command, folder, expected=0))
    return folder


def test_the_recording_is_a_data_set_of_the_camera_and_a_log_of_the_same_motions(folder: Path) -> None:
    points, log = load(folder / "points"), load_motion(folder / "recording" / "motion")
    seen = [name for name, image in zip(points.poses.names, points.poses.image or (), strict=True) if image]
    assert list(log.series) == seen
    assert np.bincount(points.points.pose)[np.unique(points.points.pose)].min() >= 4
    assert 40 < 1 / log.step_s < 60


def test_the_camera_sees_the_zero_and_the_play(folder: Path) -> None:
    found = json.loads((folder / "why" / "diagnosis.json").read_text())
    named = {(one["effect"], one["where"]): one["parameters"] for one in found["effects"]}
    for (effect, where), truth in TRUTH.items():
        (number, *_) = named[effect, where].values()
        assert abs(number["value"] - truth) < 4 * number["std"]
    assert not {effect for effect, _ in named} & set(SERVO_FAULTS)


def test_the_log_sees_the_servos(folder: Path) -> None:
    found = json.loads((folder / "servo" / "diagnosis.json").read_text())
    named = {(one["effect"], one["where"]): one["parameters"] for one in found["effects"]}
    for (effect, where, number), truth in SERVOS.items():
        assert abs(abs(named[effect, where][number]["value"]) - truth) < 0.1 * truth
    assert not {effect for effect, _ in named} & {effect for effect, _ in TRUTH}


def test_the_zero_is_written_in_ticks(folder: Path) -> None:
    before, after = (json.loads((folder / name).read_text()) for name in ("examples/so101/my_arm.json", "my_arm.json"))
    ticks = before["elbow_flex"]["homing_offset"] - after["elbow_flex"]["homing_offset"]
    assert abs(ticks - 0.05 * 4096 / (2 * np.pi)) < 1.5
    after["elbow_flex"]["homing_offset"] += ticks
    assert after == before
