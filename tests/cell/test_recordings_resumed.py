"""A recording is gone on with in its own cell, from where the arm was left, or not at all."""

from dataclasses import replace
from pathlib import Path

import bench
import numpy as np
import pytest

import robolaser
from robolaser.cell.acl import AclArm
from robolaser.cell.failures import AnswerUnclear
from robolaser.cell.recording_writer import RecordingWriter, Sample
from robolaser.cell.route import from_table, numbered, route_text
from robolaser.data.cell_config import Cell, load_cell
from robolaser.errors import DataError, Interrupted, PlanError, RobolaserError

Q = np.random.default_rng(4).uniform(-0.5, 0.5, (3, 5))
IMAGE = np.random.default_rng(1).integers(0, 255, (16, 24), dtype=np.uint8)


@pytest.fixture
def begun(cell: Cell, tmp_path: Path) -> Path:
    """A recording of three poses, two of which are done."""
    writer = bench.begun(cell, tmp_path / "out", numbered(Q))
    writer.state_quantization_noise(np.full(5, 1e-4), pytest.fail)
    for i, waypoint in enumerate(writer.waypoints[:2]):
        writer.add([Sample(waypoint.name, float(i), waypoint.q, {"image": IMAGE, "image_off": IMAGE})])
    return tmp_path / "out"


def files(folder: Path) -> dict[Path, bytes]:
    return {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_what_is_there_stays_until_the_new_one_can_be_described(cell, begun):
    before = files(begun)
    writer = RecordingWriter(cell, begun, numbered(Q), 1)
    (cell.folder / "dataset.toml").unlink()
    with pytest.raises(DataError):
        writer.add([Sample("start", 0.0, Q[0])])
    assert files(begun) == before


def test_a_recording_that_is_overwritten_leaves_no_image_behind(cell, begun):
    (begun / "images" / "mine.png").write_bytes(b"not in poses.csv")
    RecordingWriter(cell, begun, numbered(Q[2:]), 1).add([Sample("start", 0.0, Q[0])])
    assert [file.name for file in (begun / "images").iterdir()] == ["mine.png"]


def test_looking_at_what_remains_changes_nothing_on_the_disk(cell, begun):
    (begun / "images" / ".p001.png.xyz").write_bytes(b"half")
    before = files(begun)
    assert len(bench.resumed(cell, begun).remaining) == 1
    assert files(begun) == before


@pytest.mark.parametrize("wrong", ["abc", "nan", ""])
def test_a_time_that_cannot_be_read_is_named(cell, begun, wrong):
    table = begun / "poses.csv"
    table.write_text(table.read_text().replace("p002,1.000", f"p002,{wrong}"))
    with pytest.raises(DataError, match=r"row 3.*time_s"):
        bench.resumed(cell, begun)


def test_a_laser_that_can_no_longer_be_switched_is_another_cell(cell, begun):
    with pytest.raises(DataError, match="image_off"):
        bench.resumed(replace(cell, laser_output=None), begun)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [("square_m = 0.010", "square_m = 0.011", "board"), ("lower = 6e-3", "lower = 5e-3", "parameters")],
)
def test_another_cell_is_told_apart(cell, begun, before, after, said):
    text = (cell.folder / "dataset.toml").read_text()
    (cell.folder / "dataset.toml").write_text(text.replace(before, after))
    with pytest.raises(DataError, match=f"differ in {said}"):
        bench.resumed(load_cell(cell.folder), begun)


def test_a_cell_by_another_name_is_the_same_cell(cell, begun):
    text = (cell.folder / "dataset.toml").read_text()
    (cell.folder / "dataset.toml").write_text(text.replace('name = "emulated"', 'name = "mine"'))
    assert bench.resumed(load_cell(cell.folder), begun).done == 2


@pytest.mark.parametrize(
    ("before", "after", "error"),
    [
        ("p001,pose", "p001,psoe", DataError),
        ("p001,pose", "p002,pose", DataError),
        ("p001,pose", "p001,approach", DataError),
        ("q_joint_1", "q_joint_7", RobolaserError),
        (",pose,", ",approach,", RobolaserError),
    ],
)
def test_a_plan_that_was_changed_by_hand_is_looked_at(cell, tmp_path, before, after, error):
    said = route_text(cell.robot, numbered(Q))
    assert before in said
    (tmp_path / "plan.csv").write_text(said.replace(before, after))
    with pytest.raises(error):
        from_table(tmp_path / "plan.csv", cell.robot)


def interrupted(cell: Cell, rig: bench.Bench, folder: Path) -> None:
    """A day that ends by hand between two poses."""

    def by_hand() -> None:
        raise KeyboardInterrupt

    rig.clock.at.append((9.0 if cell.arm.kind == "acl" else 3.0, by_hand))
    with pytest.raises(Interrupted, match="Stopped by hand"):
        bench.session(cell, rig, bench.begun(cell, folder, bench.poses(cell, 4))).run(lambda waypoint: None)


def test_where_the_arm_was_stopped_is_on_the_disk(cell, tmp_path):
    rig = bench.bench_for(cell)
    interrupted(cell, rig, tmp_path / "out")
    poses = robolaser.load(tmp_path / "out").poses
    assert poses.names[-1] == "stopped"
    np.testing.assert_allclose(poses.q[-1], rig.motor(), atol=1e-4)
    bench.session(cell, rig, bench.resumed(cell, tmp_path / "out")).run(lambda waypoint: None)
    assert not bench.resumed(cell, tmp_path / "out").remaining


@pytest.mark.parametrize("home", [False, True])
def test_an_arm_that_counts_from_elsewhere_is_homed_before_it_goes_on(cell, tmp_path, home):
    interrupted(cell, bench.bench_for(cell), tmp_path / "out")
    anew = bench.bench_for(cell, ["reboot@1"])
    bench.arm_on(bench.Bench(anew.controller, anew.clock), cell).start_move(anew.motor() + 0.3, 1.0)
    anew.clock.wait(20.0)
    stood, there = anew.motor(), bench.at_home(cell, home)
    before = files(tmp_path / "out")
    going = bench.session(there, anew, bench.resumed(there, tmp_path / "out"))
    if home:
        going.run(lambda waypoint: None)
        assert not bench.resumed(cell, tmp_path / "out").remaining
    else:
        with pytest.raises(PlanError, match="home the arm"):
            going.run(lambda waypoint: None)
        np.testing.assert_array_equal(anew.motor(), stood)
        assert files(tmp_path / "out") == before


def test_an_arm_whose_position_is_confirmed_goes_on_without_homing(cell, tmp_path):
    rig = bench.bench_for(cell)
    interrupted(cell, rig, tmp_path / "out")
    bench.arm_on(rig, cell).start_move(rig.motor() + 0.1, 1.0)  # its computer died on the way
    rig.clock.wait(20.0)
    with pytest.raises(PlanError, match=r"arm at joint_1 .*, continue with --confirm-position"):
        bench.session(cell, rig, bench.resumed(cell, tmp_path / "out")).run(lambda waypoint: None)
    writer = bench.resumed(cell, tmp_path / "out")
    bench.session(cell, rig, writer, position_confirmed=True).run(lambda waypoint: None)
    assert not writer.remaining


def test_servos_that_were_moved_by_hand_still_know_where_they_are(tmp_path):
    cell = bench.cell(tmp_path, "lss")
    interrupted(cell, bench.bench_for(cell), tmp_path / "out")
    bench.session(cell, bench.bench_for(cell), bench.resumed(cell, tmp_path / "out")).run(lambda waypoint: None)
    assert not bench.resumed(cell, tmp_path / "out").remaining


def test_of_an_arm_that_started_anew_no_place_is_stated(cell, tmp_path):
    rig = bench.bench_for(cell, ["reboot@>9s"])
    with pytest.raises(Interrupted, match="its position is not known") as stopped:
        bench.session(cell, rig, bench.begun(cell, tmp_path / "out", bench.poses(cell, 4))).run(lambda waypoint: None)
    assert "It is at" not in str(stopped.value)
    assert "It last rested at" in str(stopped.value)
    assert "stopped" not in robolaser.load(tmp_path / "out").poses.names


def test_it_is_said_what_comes_next(cell, tmp_path):
    rig, said = bench.bench_for(cell), []
    there = bench.at_home(cell, True)
    going = bench.session(there, rig, bench.begun(there, tmp_path / "out", bench.poses(cell, 2)))
    going.run(lambda waypoint: said.append(f"done {waypoint.name}"), said.append)
    assert said == ["homing", "p001", "done p001", "p002", "done p002"]


def test_the_laser_goes_off_though_no_stop_is_heard(cell, tmp_path, monkeypatch):
    rig = bench.bench_for(cell)
    running = bench.session(cell, rig, bench.begun(cell, tmp_path / "new", bench.poses(cell, 2)))

    def unheard(_: AclArm) -> None:
        raise AnswerUnclear("The stop was not heard.")

    def by_hand(_: object) -> None:
        assert rig.controller.outputs(rig.clock.now())
        raise KeyboardInterrupt

    monkeypatch.setattr(AclArm, "stop", unheard)
    with pytest.raises(Interrupted, match=r"could not be seen to stop\. The stop was not heard"):
        running.run(by_hand)
    assert not rig.controller.outputs(rig.clock.now())
