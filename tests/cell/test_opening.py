"""What a cell names is opened, and only then."""

import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from installed import installed

from robolaser.cell.arm import ARMS, Arm, arm_class
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import Cell, load_cell
from robolaser.errors import ArmError, DataError, DependencyMissing, RobolaserError

DESK_ARM = """
import numpy as np
from robolaser.cell.arm import Arm

class DeskArm(Arm):
    outputs, synchronous_read, absolute_encoders, step = 0, True, True, np.zeros(5)

    @classmethod
    def open(cls, cell, clock): return cls()
    def read(self): return np.zeros(5)
    def poll_faults(self): pass
    def start_move(self, q, seconds): pass
    def stop(self): pass
    def home(self): pass
    def close(self): pass
"""


def open_arm(cell: Cell) -> Arm:
    return arm_class(cell).open(cell, Clock())


def named(cell: Cell, kind: str, port: str) -> Cell:
    laser = cell.laser_output if kind == "acl" else None
    return replace(cell, arm=replace(cell.arm, kind=kind, port=port), laser_output=laser)


def test_importing_devices_opens_nothing():
    code = (
        "import pkgutil, importlib, sys, threading, robolaser.cell as d\n"
        "for module in pkgutil.iter_modules(d.__path__): importlib.import_module('robolaser.cell.' + module.name)\n"
        "print(threading.active_count(), 'serial' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["1", "False"]


def test_an_arm_of_an_installed_package_is_opened(cell, tmp_path, monkeypatch):
    installed(tmp_path, "desk_arm", DESK_ARM, "[robolaser.arms]\ndesk = desk_arm:DeskArm\n")
    monkeypatch.syspath_prepend(tmp_path)
    with closing(open_arm(named(cell, "desk", str(cell.folder)))) as arm:
        assert type(arm).__name__ == "DeskArm"


@pytest.mark.parametrize("kind", sorted(ARMS))
def test_what_is_not_there_is_named(cell, kind):
    with pytest.raises((ArmError, DataError, DependencyMissing), match="nowhere"):
        open_arm(named(cell, kind, "/nowhere"))


@pytest.mark.parametrize("kind", ["acl", "dynamixel", "feetech", "lss"])
def test_what_does_not_answer_as_it_should_is_said_so(cell, kind):
    """A plug that leads back to where it came from."""
    with pytest.raises(RobolaserError, match="loop://"):
        open_arm(named(cell, kind, "loop://"))


def test_a_recording_of_another_arm_is_no_replay(cell, tmp_path):
    (tmp_path / "other").mkdir()
    said = (cell.folder / "dataset.toml").read_text().replace('"joint_4", "joint_5"', '"joint_4"')
    (tmp_path / "other" / "dataset.toml").write_text(said)
    (tmp_path / "other" / "robot.urdf").write_text((cell.folder / "robot.urdf").read_text())
    (tmp_path / "other" / "poses.csv").write_text("pose,q_joint_1,q_joint_2,q_joint_3,q_joint_4\na,0,0,0,0\n")
    with pytest.raises(DataError, match="joint_5, not of joint_1, joint_2, joint_3, joint_4"):
        open_arm(named(cell, "replay", str(tmp_path / "other")))


def test_a_recording_replays_each_joint_by_its_name_whatever_their_order(cell, tmp_path):
    (tmp_path / "other").mkdir()
    described, joints = (cell.folder / "dataset.toml").read_text(), [f"joint_{i}" for i in range(1, 6)]
    listed = ", ".join(f'"{joint}"' for joint in joints)
    assert listed in described
    backwards = described.replace(listed, ", ".join(f'"{joint}"' for joint in reversed(joints)))
    (tmp_path / "other" / "dataset.toml").write_text(backwards)
    (tmp_path / "other" / "robot.urdf").write_text((cell.folder / "robot.urdf").read_text())
    readings = ",".join(f"0.{i}" for i in range(1, 6))
    (tmp_path / "other" / "poses.csv").write_text(f"pose,{','.join(f'q_{j}' for j in joints)}\na,{readings}\n")
    assert open_arm(named(cell, "replay", str(tmp_path / "other"))).read().tolist() == [0.1, 0.2, 0.3, 0.4, 0.5]


@pytest.mark.parametrize(("kind", "said"), [("acl", "outputs 1 to 16"), ("lss", r"take \[laser\] out")])
def test_an_output_that_the_controller_does_not_have_is_named_before_a_line_is_opened(cell, kind, said):
    there = replace(named(cell, kind, "/nowhere"), laser_output=99)
    with pytest.raises(DataError, match=said):
        open_arm(there)


def test_a_port_that_nobody_names_is_asked_for(cell):
    with pytest.raises(DataError, match=r"\[arm\] port"):
        open_arm(named(cell, "acl", ""))


def changed(cell: Cell, before: str, after: str, file: str = "cell.toml") -> Path:
    said = (cell.folder / file).read_text()
    assert before in said
    (cell.folder / file).write_text(said.replace(before, after))
    return cell.folder


@pytest.mark.parametrize("wrong", ["[0, 1, 1, 1, 1]", "[2, 1, 1, 1, 1]", "[1, 1, 1, 1]"])
def test_a_joint_counts_up_or_down(cell, wrong):
    with pytest.raises(DataError, match=r"\[arm\] direction"):
        load_cell(changed(cell, "direction = [1, -1, 1, 1, -1]", f"direction = {wrong}"))


@pytest.mark.parametrize("wrong", ["[1, 2, 3, 4, 4]", "[1, 2, 3, 4, 5.5]", "[1, 2, 3, 4, 254]", "[1, 2, 3, 4, -1]"])
def test_each_servo_has_an_address_of_its_own(cell, wrong):
    with pytest.raises(DataError, match=r"\[arm\] ids"):
        load_cell(changed(cell, "baud = 9600", f"baud = 9600\nids = {wrong}"))


def test_a_cell_without_a_robot_is_said_to_have_none(cell):
    said = (cell.folder / "dataset.toml").read_text()
    (cell.folder / "dataset.toml").write_text(said[: said.index("[robot]")] + said[said.index("[sensor]") :])
    with pytest.raises(DataError, match=r"lacks \[robot\]"):
        load_cell(cell.folder)


def test_limits_that_are_not_set_are_pointed_out(cell):
    sentences = " ".join(load_cell(cell.folder).warnings)
    assert "no reach_m" in sentences
    assert "no floor_m" not in sentences


@pytest.mark.parametrize("scheme", ["spy", "SPY", "alt", "cp2110", "hwgrep", "file", "http"])
@pytest.mark.parametrize("kind", ["acl", "lss"])
def test_no_other_url_is_opened_and_no_file_is_touched(cell, kind, scheme, tmp_path):
    mine = tmp_path / "mine.txt"
    mine.write_text("twenty characters!!!")
    with pytest.raises(ArmError, match=r"not allowed.*socket://HOST:PORT"):
        open_arm(named(cell, kind, f"{scheme}://loop://?file={mine}"))
    assert mine.read_text() == "twenty characters!!!"
