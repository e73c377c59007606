"""What a cell names is opened, and only then."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import bench
import pytest

from robolaser.cell import Cell
from robolaser.devices.arms import ARMS, open_arm
from robolaser.devices.clock import WallClock
from robolaser.errors import ArmDiffers, ArmUnknown, NotADataset, PortUnusable, RobolaserError


@pytest.fixture
def cell(tmp_path: Path) -> Cell:
    return bench.cell(tmp_path)


def named(cell: Cell, kind: str, port: str) -> Cell:
    return replace(cell, arm=replace(cell.arm, kind=kind, port=port))


def test_importing_devices_opens_nothing() -> None:
    code = (
        "import pkgutil, importlib, sys, threading, robolaser.devices as d\n"
        "for module in pkgutil.iter_modules(d.__path__): importlib.import_module('robolaser.devices.' + module.name)\n"
        "print(threading.active_count(), 'serial' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["1", "False"]


def test_a_language_that_nobody_speaks_is_named(cell: Cell) -> None:
    with pytest.raises(ArmUnknown, match=r"no arm speaks 'acll'.*Did you mean 'acl'"):
        open_arm(named(cell, "acll", "loop://"), WallClock())


@pytest.mark.parametrize("kind", sorted(ARMS))
def test_what_is_not_there_is_named(cell: Cell, kind: str) -> None:
    with pytest.raises((PortUnusable, NotADataset), match="nowhere"):
        open_arm(named(cell, kind, "/nowhere"), WallClock())


@pytest.mark.parametrize("kind", ["acl", "lss"])
def test_what_does_not_answer_as_it_should_is_said_so(cell: Cell, kind: str) -> None:
    """A plug that leads back to where it came from."""
    with pytest.raises(RobolaserError, match="loop://"):
        open_arm(named(cell, kind, "loop://"), WallClock())


def test_a_recording_of_another_arm_is_no_replay(cell: Cell, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    said = (cell.folder / "dataset.toml").read_text().replace('"joint_4", "joint_5"', '"joint_4"')
    (tmp_path / "other" / "dataset.toml").write_text(said)
    (tmp_path / "other" / "robot.urdf").write_text((cell.folder / "robot.urdf").read_text())
    (tmp_path / "other" / "poses.csv").write_text("pose,q_joint_1,q_joint_2,q_joint_3,q_joint_4\na,0,0,0,0\n")
    with pytest.raises(ArmDiffers):
        open_arm(named(cell, "replay", str(tmp_path / "other")), WallClock())
