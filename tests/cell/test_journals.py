"""A recording on the disk is whole after every pose."""

import csv
import errno
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bench
import cv2
import numpy as np
import pytest
from failing_disk import contents, restore, watched

import robolaser
from robolaser.cell.recording_writer import RecordingWriter, Sample
from robolaser.cell.route import Waypoint, both_ways, from_diagnosis, from_table, numbered, route_text, way
from robolaser.data.cell_config import Cell
from robolaser.data.result_folder import STAGED, results_in
from robolaser.errors import DataError, OutputError, PlanError
from robolaser.robot.kinematics import Robot

Q = np.random.default_rng(4).uniform(-0.5, 0.5, (4, 5))
COLUMNS = ("image", "image_2", "image_off")


@pytest.fixture
def robot(cell: Cell) -> Robot:
    return cell.description.robot


def sample(waypoint: Waypoint, time_s: float) -> Sample:
    rng = np.random.default_rng(int(time_s))
    return Sample(
        waypoint.name, time_s, waypoint.q, {c: rng.integers(0, 255, (16, 24), dtype=np.uint8) for c in COLUMNS}
    )


def with_two_poses(cell: Cell, folder: Path, waypoints: Sequence[Waypoint] = numbered(Q)) -> RecordingWriter:
    writer = bench.begun(cell, folder, waypoints, shots=2)
    writer.add([Sample("start", 0.0, Q[3])])
    for i in range(2):
        writer.add([sample(waypoints[i], 1.0 + i)])
    return writer


def test_a_recording_is_a_data_set_after_every_entry(cell, tmp_path):
    folder = tmp_path / "out"
    writer = bench.begun(cell, folder, numbered(Q), shots=2)
    assert not folder.exists()
    writer.add([Sample("start", 0.0, Q[3])])
    assert robolaser.load(folder).poses.names == ("start",)
    for i, waypoint in enumerate(numbered(Q)):
        writer.add([sample(waypoint, 1.0 + i)])
        poses = robolaser.load(folder).poses
        assert len(poses) == 2 + i
        np.testing.assert_array_equal(poses.q[-1], waypoint.q)
        for column in COLUMNS:
            name = (poses.image or ())[-1] if column == "image" else poses.extra[column][-1]
            assert (folder / name).is_file()
    assert robolaser.load(folder).robot is not None
    assert writer.done == 4
    assert not writer.remaining


def test_the_images_are_the_ones_that_were_taken(cell, tmp_path):
    want = sample(with_two_poses(cell, tmp_path / "out").waypoints[1], 2.0).images
    for column, image in want.items():
        name = f"images/p002{column.removeprefix('image').replace('_', '.')}.png"
        np.testing.assert_array_equal(cv2.imread(str(tmp_path / "out" / name), cv2.IMREAD_UNCHANGED), image)


@pytest.mark.parametrize("at", range(5))
def test_a_full_disk_leaves_the_recording_as_it_was(cell, tmp_path, at, monkeypatch):
    writer = with_two_poses(cell, tmp_path / "out")
    before = {file: file.read_bytes() for file in (tmp_path / "out").rglob("*") if file.is_file()}
    left = [at]
    sync = os.fsync

    def fills(descriptor: int) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", fills)
    if at < 4:
        with pytest.raises(OutputError, match="No space left"):
            writer.add([sample(writer.waypoints[2], 3.0)])
        assert {file: file.read_bytes() for file in (tmp_path / "out").rglob("*") if file.is_file()} == before
        monkeypatch.undo()
    writer.add([sample(writer.waypoints[2], 3.0)])
    assert len(robolaser.load(tmp_path / "out").poses) == 4


def test_a_recording_that_is_there_stays_until_the_first_entry(cell, tmp_path):
    with_two_poses(cell, tmp_path / "out")
    (tmp_path / "out" / "points.csv").write_text("pose,point\n")
    anew = RecordingWriter(cell, tmp_path / "out", numbered(Q), 1)
    assert len((tmp_path / "out" / "poses.csv").read_text().splitlines()) == 4
    anew.add([Sample("start", 0.0, Q[0])])
    assert robolaser.load(tmp_path / "out").poses.names == ("start",)


def test_going_on_begins_at_the_next_pose(cell, tmp_path):
    with_two_poses(cell, tmp_path / "out")
    writer = bench.resumed(cell, tmp_path / "out")
    assert [waypoint.name for waypoint in writer.remaining] == ["p003", "p004"]
    assert writer.time_s > 2.0
    writer.add([Sample(writer.unused("resumed"), writer.time_s, Q[0]), sample(writer.waypoints[2], writer.time_s + 1)])
    again = bench.resumed(cell, tmp_path / "out")
    assert [waypoint.name for waypoint in again.remaining] == ["p004"]
    assert again.unused("resumed") == "resumed_2"


def test_killed_at_any_moment_a_pose_is_in_the_recording_or_is_visited_again(cell, tmp_path):
    folder, left = tmp_path / "out", tmp_path / "left"
    moments: list[dict[str, bytes]] = []
    with results_in(folder, command="record", files=bench.begun(cell, folder, numbered(Q), shots=2).files):
        writer = with_two_poses(cell, folder)
        with watched(folder, lambda _: moments.append(contents(folder))):
            writer.add([sample(writer.waypoints[2], 3.0)])
    for moment in moments:
        restore(left, moment)
        again = bench.resumed(cell, left)
        assert again.done in (2, 3)
        with results_in(left, command="record", files=again.files, force=True):
            for waypoint in again.remaining:
                again.add([sample(waypoint, 4.0)])
        assert len(robolaser.load(left).poses) == 1 + len(Q)
        assert not [name for name in contents(left) if STAGED in name]


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("damage", ["gone", "empty", "cut", "zeros", "jpeg"])
def test_a_pose_whose_image_is_broken_is_visited_again(cell, tmp_path, column, damage):
    folder, waypoints = tmp_path / "out", both_ways(numbered(Q[:2]), 0.05)
    writer = bench.begun(cell, folder, waypoints, shots=2)
    with results_in(folder, command="record", files=writer.files):
        for i, waypoint in enumerate(waypoints[:2]):
            writer.add([Sample(waypoint.approach_names[0], i, waypoint.approach[0]), sample(waypoint, i + 0.5)])
    image = folder / "images" / f"p001_down{column.removeprefix('image').replace('_', '.')}.png"
    data = image.read_bytes()
    image.unlink()
    if damage != "gone":
        jpeg = cv2.imencode(".jpg", np.zeros((16, 24), np.uint8))[1].tobytes()
        left = {"empty": b"", "cut": data[:-9], "zeros": data[:-9] + bytes(9), "jpeg": jpeg[:-9]}
        image.write_bytes(left[damage])
    writer = bench.resumed(cell, folder)
    assert [waypoint.name for waypoint in writer.remaining] == ["p001_down", "p002_up", "p002_down"]
    again = writer.remaining[0]
    with results_in(folder, command="record", files=writer.files, force=True):
        writer.add([Sample(again.approach_names[0], 9.0, again.approach[0]), sample(again, 9.5)])
    assert robolaser.load(folder).poses.names == ("p001_up_from", "p001_up", "p001_down_from", "p001_down")
    np.testing.assert_array_equal(cv2.imread(str(image), cv2.IMREAD_UNCHANGED), sample(again, 9.5).images[column])


def test_an_image_without_a_row_is_replaced_if_the_recording_took_it(cell, tmp_path):
    folder = tmp_path / "out"
    with results_in(folder, command="record", files=bench.begun(cell, folder, numbered(Q), shots=2).files):
        with_two_poses(cell, folder)
        image = folder / "images" / "p003.png"
        image.write_bytes(b"")
    writer = bench.resumed(cell, folder)
    with results_in(folder, command="record", files=writer.files, force=True):
        writer.add([sample(writer.remaining[0], 3.0)])
    assert cv2.imread(str(image), cv2.IMREAD_UNCHANGED) is not None
    foreign = folder / "images" / "p004.png"
    foreign.write_bytes(b"mine")
    with (
        pytest.raises(OutputError, match="not its own"),
        results_in(folder, command="record", files=bench.resumed(cell, folder).files, force=True),
    ):
        pytest.fail("somebody else's image is not touched")
    assert foreign.read_bytes() == b"mine"


def test_going_on_with_another_plan_is_refused(cell, tmp_path):
    with pytest.raises(DataError, match="no recording was begun"):
        bench.resumed(cell, tmp_path / "out")
    with_two_poses(cell, tmp_path / "out")
    assert RecordingWriter.resume(cell, tmp_path / "out", numbered(Q), 2).done == 2
    with pytest.raises(PlanError, match="2 shots a pose, not 3"):
        RecordingWriter.resume(cell, tmp_path / "out", None, 3)
    with pytest.raises(PlanError, match="4 poses"):
        RecordingWriter.resume(cell, tmp_path / "out", numbered(Q[:3]), None)


def test_a_pose_may_have_any_name(cell, tmp_path):
    names = ("a/b", 'ü, "x"', "..", "visit-0001", "a", "a_2")
    waypoints = [Waypoint(name, q) for name, q in zip(names, np.random.default_rng(1).normal(size=(6, 5)), strict=True)]
    writer = bench.begun(cell, tmp_path / "out", waypoints, shots=2)
    for i, waypoint in enumerate(waypoints):
        writer.add([sample(waypoint, float(i))])
    poses = robolaser.load(tmp_path / "out").poses
    assert poses.names == names
    assert len(set(poses.image or ())) == 6
    assert not bench.resumed(cell, tmp_path / "out").remaining


def test_a_route_reads_back_as_it_was_written(robot, tmp_path):
    waypoints = (*both_ways(numbered(Q / 3), 0.1), Waypoint("last, one", Q[0]))
    (tmp_path / "plan.csv").write_text(route_text(robot, waypoints))
    back = from_table(tmp_path / "plan.csv", robot)
    assert [waypoint.name for waypoint in back] == [waypoint.name for waypoint in waypoints]
    np.testing.assert_array_equal(way(back)[1], way(waypoints)[1])
    assert way(back)[0] == way(waypoints)[0]


def test_both_ways_come_from_below_and_from_above():
    up, down = both_ways(numbered(Q[:1]), 0.1)
    assert (up.approach[0] < up.q).all()
    assert (down.approach[0] > down.q).all()
    assert (up.name, up.approach_names, down.name) == ("p001_up", ("p001_up_from",), "p001_down")


def test_poses_of_a_recording_are_those_with_an_image(cell, robot, tmp_path):
    with_two_poses(cell, tmp_path / "out")
    waypoints = from_table(tmp_path / "out" / "poses.csv", robot)
    assert [waypoint.name for waypoint in waypoints] == ["p001", "p002"]
    np.testing.assert_array_equal(way(waypoints)[1], Q[:2])


def test_no_pose_has_the_name_that_another_ones_approach_will_have(robot, tmp_path):
    poses = (Waypoint("a", Q[0] / 3, (Q[1] / 3,)), Waypoint("a_from", Q[2] / 3))
    for order in (poses, poses[::-1]):
        (tmp_path / "plan.csv").write_text(route_text(robot, order))
        with pytest.raises(DataError, match="a_from is taken"):
            from_table(tmp_path / "plan.csv", robot)


HEADER = "pose,q_joint_1,q_joint_2,q_joint_3,q_joint_4,q_joint_5\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "poses.csv"),
        (HEADER, "gives no poses for this arm: it has a header and no rows"),
        (HEADER.replace("_5", "_6") + "a,0,0,0,0,0\n", "q_joint_5"),
        (HEADER + "a,0,0,0,0,x\n", "row 2.*q_joint_5"),
        (HEADER + "a,0,0,0,0,nan\n", "row 2.*q_joint_5"),
        (HEADER + "a,0,0,0,0,0\na,0,0,0,0,0\n", "row 3"),
    ],
)
def test_poses_that_cannot_be_gone_to_are_named(robot, tmp_path, text, message):
    (tmp_path / "poses.csv").write_text(text)
    with pytest.raises(DataError, match=message):
        from_table(tmp_path / "poses.csv", robot)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "it is not JSON"),
        ("[]", "next_poses is not a list"),
        ("{}", "it lacks 'next_poses'"),
        ('{"next_poses": []}', "next_poses is empty"),
        ('{"next_poses": [{"joint_1": 0}]}', "it lacks 'joint_2'"),
        ('{"next_poses": [3]}', "next_poses is not a list"),
        (
            '{"next_poses": [{"joint_1": "x", "joint_2": 0, "joint_3": 0, "joint_4": 0, "joint_5": 0}]}',
            "next_poses is not a list",
        ),
    ],
)
def test_a_diagnosis_that_asks_for_nothing_is_named(robot, tmp_path, text, message):
    (tmp_path / "d.json").write_text(text)
    with pytest.raises(DataError, match=message):
        from_diagnosis(tmp_path / "d.json", robot)


def test_a_laser_that_cannot_be_switched_leaves_no_column(cell, tmp_path):
    always: Any = replace(cell, laser_output=None)
    bench.begun(always, tmp_path / "out", numbered(Q), shots=1).add([Sample("start", 0.0, Q[0])])
    with (tmp_path / "out" / "poses.csv").open(newline="") as file:
        assert next(csv.reader(file))[-1] == "image"


@pytest.mark.parametrize("noise", ["", "[noise]\npixel_px = 0.1\n"])
def test_a_recording_states_how_finely_joints_were_read(cell, robot, tmp_path, noise):
    said = cell.folder / "dataset.toml"
    said.write_text(f"{said.read_text('utf-8')}\n{noise}", "utf-8")
    writer = RecordingWriter(cell, tmp_path / "out", numbered(Q), 1)
    writer.state_quantization_noise(np.full(len(robot.joints), 1e-3), pytest.fail)
    writer.add([Sample("start", 0.0, Q[0])])
    stated = robolaser.load(tmp_path / "out").noise
    assert stated.joint_rad == pytest.approx(1e-3 / np.sqrt(12), rel=0.02)
    assert stated.pixel_px == (0.1 if noise else None)
