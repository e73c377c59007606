"""robolaser record on an emulated cell."""

import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from emulator_process import EmulatorProcess
from terminal import Rig, emulated

import robolaser
from robolaser.cell.serial_line import SerialLine
from robolaser.cli import main
from robolaser.estimation import optimal_poses

EXAMPLE = Path(__file__).parents[2] / "examples" / "cell"
HURRY = 40.0


@pytest.fixture
def acl(tmp_path: Path) -> Rig:
    return Rig(tmp_path, "acl")


def test_a_recording_is_taken_over_a_real_pseudo_terminal(tmp_path, capsys):
    """As in test_watched_cell.py, where the arm has a laser on its output."""
    rig = Rig(tmp_path, "lss")
    with EmulatorProcess(rig.folder, time_scale=HURRY) as running:
        assert rig.record("--poses", str(rig.poses), "--repeats", "2", "--move", port=running.arm) == 0
    assert rig.names() == ["a", "b", "c"]
    dataset = robolaser.load(rig.out)
    assert dataset.robot is not None
    assert dataset.board is not None
    assert "image_2" in dataset.poses.extra
    assert "image_off" not in dataset.poses.extra
    assert "Wrote 3 of 3 poses" in capsys.readouterr().out


def test_both_ways_see_each_pose_from_below_and_above(acl):
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--both-ways", "--move", port=port) == 0
    poses = robolaser.load(acl.out).poses
    assert poses.names[1:5] == ("a_up_from", "a_up", "a_down_from", "a_down")
    assert (poses.q[1] < poses.q[2] - 0.05).all()
    assert (poses.q[3] > poses.q[4] + 0.05).all()
    np.testing.assert_allclose(poses.q[2], poses.q[4], atol=1e-4)


@pytest.mark.parametrize("asked", [["--dry-run"], []])
def test_nothing_moves_and_no_port_is_opened_without_move(acl, asked, monkeypatch, capsys):
    monkeypatch.setattr(SerialLine, "open", lambda *_: pytest.fail("a port was opened"))
    assert acl.record("--poses", str(acl.poses), *asked, port="nowhere") == (0 if asked else 2)
    said = capsys.readouterr()
    assert re.search(r"^a +-?\d+\.\d\d° .*", said.out, re.MULTILINE)
    assert "3 poses;" in said.out
    assert asked or "--move" in said.err
    assert not acl.out.exists()


def test_a_pose_below_the_floor_keeps_everything_from_moving(acl, capsys):
    cell = acl.folder / "cell.toml"
    cell.write_text(cell.read_text().replace("floor_m = -0.5", "floor_m = 0.6"))
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 1
    said = capsys.readouterr().err
    assert "Nothing was moved" in said
    assert re.search(r"b: the lowest part at 0\.\d+ m, limit 0\.600 m", said)
    assert not (acl.out / "poses.csv").exists()


@pytest.mark.parametrize(
    ("asked", "code", "said"),
    [
        ([], 2, "State where the arm should go"),
        (["--resume", "--move"], 1, "no recording was begun there"),
        (["--poses", "absent.csv", "--move"], 1, "absent.csv"),
        (["--next", "absent.json", "--move"], 1, "absent.json"),
        (["--poses", "p.csv", "--run-up", "5", "--move"], 2, "--run-up has no effect without --both-ways"),
        (["--poses", "p.csv", "--seed", "5", "--move"], 2, "--seed has no effect without --plan"),
        (["--poses", "p.csv", "--separate", "backlash", "--move"], 2, "--separate has no effect without --plan"),
        (["--resume", "--both-ways", "--move"], 2, "--both-ways has no effect without"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_sentence(acl, asked, code, said, capsys):
    assert acl.record(*asked, port="/dev/absent") == code
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("port", "said"),
    [
        ("/dev/absent", r"Cannot open port /dev/absent.*--port"),
        ("nonsense://x", r"Port nonsense://x: nonsense:// is not allowed"),
        ("socket://127.0.0.1:1", r"Cannot open port socket://127.0.0.1:1"),
    ],
)
def test_a_wrong_port_is_named(acl, port, said, capsys):
    assert acl.record("--poses", str(acl.poses), "--move", port=port) == 1
    assert re.search(said, capsys.readouterr().err, re.DOTALL)
    assert not (acl.out / "plan.csv").exists()


def test_a_wrong_speed_is_told_from_a_broken_arm(acl, capsys):
    with emulated(acl, "lost:1", "flood:100") as port:  # what comes has no meaning
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 1
    assert "baud" in capsys.readouterr().err


def test_ctrl_c_stops_the_arm_and_says_where_it_stands(acl):
    script = f"import sys; sys.path += {sys.path!r}; from terminal import recorded; sys.exit(recorded(sys.argv[1:]))"
    header, first, *rest = acl.poses.read_text().splitlines()
    name, _, *others = first.split(",")
    acl.poses.write_text("\n".join([header, ",".join([name, "1.0", *others]), *rest]))  # in a quarter of a minute
    with EmulatorProcess(acl.folder, time_scale=HURRY) as running:
        asked = [acl.folder, "--output", acl.out, "--poses", acl.poses, "--port", running.arm, "--move"]
        cell = acl.folder / "cell.toml"
        cell.write_text(cell.read_text().replace("speed_rad_s = 1.0", "speed_rad_s = 0.01"))
        command = [sys.executable, "-c", script, *map(str, asked)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            try:
                wait_for((acl.out / "poses.csv").exists)
                time.sleep(0.5)
                process.send_signal(signal.SIGINT)
                _, said = process.communicate(timeout=60)
            finally:
                process.kill()
    assert process.returncode == 1
    assert "Stopped by hand." in said
    assert "It is at joint_1" in said
    assert "0 of 3 poses are in" in said
    assert "Traceback" not in said


def wait_for(there: Callable[[], bool]) -> None:
    for _ in range(2400):
        if there():
            return
        time.sleep(0.05)
    pytest.fail("it never came")


def test_a_recording_passes_for_a_cell(acl):
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--repeats", "2", "--move", port=port) == 0
    first, acl.out = acl.out, acl.out.with_name("again")
    cell = acl.folder / "cell.toml"
    cell.write_text(cell.read_text().replace('kind = "acl"', 'kind = "replay"'))
    asked = ["record", acl.folder, "--output", acl.out, "--poses", acl.poses, "--repeats", "2", "--move"]
    assert main([*map(str, asked), "--port", str(first), "--camera", str(first)]) == 0
    old, new = robolaser.load(first).poses, robolaser.load(acl.out).poses
    assert new.names == old.names
    np.testing.assert_array_equal(new.q[1:], old.q[1:])
    for image in (first / "images").iterdir():
        assert (acl.out / "images" / image.name).read_bytes() == image.read_bytes()


def test_an_existing_recording_is_left_alone_unless_forced(acl, capsys):
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 0
        before = (acl.out / "poses.csv").read_bytes()
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 1
        assert "--force" in capsys.readouterr().err
        assert (acl.out / "poses.csv").read_bytes() == before
        assert acl.record("--poses", str(acl.poses), "--move", "--force", port=port) == 0
    assert (acl.out / "poses.csv").read_bytes() != before


def test_a_folder_that_cannot_be_written_is_named_before_anything_moves(acl, monkeypatch, capsys):
    monkeypatch.setattr(SerialLine, "open", lambda *_: pytest.fail("a port was opened"))
    acl.out.write_text("a file")
    assert acl.record("--poses", str(acl.poses), "--move", port="nowhere") == 1
    assert "recording" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('kind = "acl"', 'kind = "acll"', "'acll', expected one of acl, dynamixel"),
        ("output = 1", "output = 99", "outputs 1 to 16"),
    ],
)
def test_a_plan_is_not_printed_for_an_arm_that_cannot_be(acl, before, after, said, capsys):
    cell = acl.folder / "cell.toml"
    cell.write_text(cell.read_text().replace(before, after))
    assert acl.record("--poses", str(acl.poses), "--dry-run", port="nowhere") == 1
    heard = capsys.readouterr()
    assert said in heard.err
    assert not heard.out


def test_limits_that_are_not_set_are_pointed_out_with_the_plan(acl, capsys):
    assert acl.record("--poses", str(acl.poses), "--dry-run", port="nowhere") == 0
    assert "[limits] has no reach_m" in capsys.readouterr().err


def test_degrees_are_told_from_radians(acl, capsys):
    acl.poses.write_text(acl.poses.read_text().splitlines()[0] + "\na,10,-20,30,0,0\n")
    assert acl.record("--poses", str(acl.poses), "--dry-run", port="nowhere") == 1
    assert re.search(r"poses\.csv, row 2: q_joint_1 is 10 rad.*Are these degrees\?", capsys.readouterr().err)


@pytest.mark.parametrize("both", [[], ["--both-ways"]])
def test_a_run_up_is_spoken_of_where_there_is_one(acl, both, capsys):
    cell = acl.folder / "cell.toml"
    cell.write_text(cell.read_text().replace("floor_m = -0.5", "floor_m = 0.9"))
    assert acl.record("--poses", str(acl.poses), "--dry-run", *both, port="nowhere") == 1
    assert ("smaller --run-up" in capsys.readouterr().err) == bool(both)


def test_a_recording_that_is_finished_moves_nothing(acl, monkeypatch, capsys):
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 0
    before = (acl.out / "poses.csv").read_bytes()
    acl.home_first()
    monkeypatch.setattr(SerialLine, "open", lambda *_: pytest.fail("a port was opened"))
    assert acl.record("--resume", "--move", port="nowhere") == 0
    assert "No pose remains." in capsys.readouterr().out
    assert acl.record("--resume", "--move", "--json", port="nowhere") == 0
    assert json.loads(capsys.readouterr().out) == {"recording": str(acl.out), "poses": 3, "planned": 3}
    assert (acl.out / "poses.csv").read_bytes() == before


def test_a_cell_is_not_recorded_over(acl, capsys):
    acl.out = acl.folder
    assert acl.record("--poses", str(acl.poses), "--move", "--force", port="nowhere") == 1
    assert "is an input of this command or is inside one" in capsys.readouterr().err
    assert (acl.folder / "robot.urdf").is_file()


def test_a_recording_in_place_of_an_arm_is_not_recorded_over(acl, capsys):
    cell, replayed = acl.folder / "cell.toml", acl.folder.with_name("replayed")
    cell.write_text(cell.read_text().replace('kind = "acl"', 'kind = "replay"'))
    acl.out = replayed / "again"
    assert acl.record("--poses", str(acl.poses), "--move", port=str(replayed)) == 1
    assert "is an input of this command or is inside one" in capsys.readouterr().err
    assert not replayed.exists()


def test_a_long_way_without_a_computer_is_warned_of(acl, capsys):
    cell = acl.folder / "cell.toml"
    cell.write_text(cell.read_text().replace("[arm]\n", "[arm]\nunattended_s = 5\n"))
    assert acl.record("--poses", str(acl.poses), "--dry-run", port="nowhere") == 0
    assert "if this computer dies, the arm moves on for up to 5 s" in capsys.readouterr().err


def test_a_plan_that_is_to_tell_an_effect_apart_is_another_one(monkeypatch, capsys):
    monkeypatch.setattr(optimal_poses, "LEAST_CANDIDATES", 12)
    asked = ["record", str(EXAMPLE), "--output", "nowhere", "--plan", "2", "--dry-run"]
    plans = []
    for more in ([], ["--separate", "joint_compliance:joint_2"]):
        assert main([*asked, *more]) == 0
        plans.append(capsys.readouterr().out)
    assert plans[0] != plans[1]
    assert main([*asked, "--separate", "joint_complience"]) == 2
    assert "Did you mean 'joint_compliance'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("impact:2@45", "joint_2"),
        ("stall:3@45", "joint_3"),
        ("silent@52", "is lost"),
        ("cut@52", "is lost"),
        ("flood:100000@52", "without end"),
        ("reboot@52", "restarted"),
    ],
)
def test_after_a_fault_the_recording_is_gone_on_with(acl, fault, said, capsys):
    with emulated(acl, fault) as port:
        assert acl.record("--poses", str(acl.poses), "--move", port=port) == 1
    message = capsys.readouterr().err
    assert said in message
    assert re.search(r"It is at joint_1 -?\d|could not be seen to stop|position is not known", message)
    assert ("position is not known" in message) == (fault == "reboot@52")
    assert "--resume" in message or "Nothing was recorded" in message
    there = (acl.out / "plan.csv").exists()
    done = acl.names() if there else []
    acl.home_first()
    with emulated(acl) as port:
        assert acl.record("--poses", str(acl.poses), "--move", *(["--resume"] if there else []), port=port) == 0
    assert acl.names() == ["a", "b", "c"]
    assert acl.names()[: len(done)] == done
