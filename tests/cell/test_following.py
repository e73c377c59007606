"""Arms that follow setpoints are recorded with the log of their motions."""

import csv
from dataclasses import replace
from pathlib import Path

import bench
import numpy as np
import pytest

from robolaser.cell.arm import arm_class
from robolaser.cell.following import BEHIND, SetpointStreamer, smooth
from robolaser.cell.route import Waypoint, both_ways
from robolaser.data.cell_config import Cell
from robolaser.emulator.bus_servos import BusServos
from robolaser.emulator.controller import ArmFault
from robolaser.emulator.servo_loop import ServoLoop
from robolaser.errors import ArmError, DataError, Interrupted
from robolaser.motion.reading import load_motion

HZ = 50.0
LAG = {("lag", "joint_2"): 0.05, ("dead_zone", "joint_3"): 0.02}


@pytest.fixture(params=["dynamixel", "feetech"])
def cell(request: pytest.FixtureRequest, tmp_path: Path) -> Cell:
    made = bench.cell(tmp_path, request.param)
    return replace(made, arm=replace(made.arm, setpoint_hz=HZ, baud=1_000_000))


def rig_of(cell: Cell, *faults: str) -> bench.Bench:
    controller = BusServos(cell, ServoLoop(cell.robot, LAG))
    return bench.Bench(controller, bench.Jumping(), faults, baud=cell.arm.baud)


def places(cell: Cell, count: int) -> tuple[Waypoint, ...]:
    return both_ways(bench.poses(cell, count), 0.1)


def recorded(cell: Cell, rig: bench.Bench, folder: Path, count: int = 2) -> None:
    bench.session(cell, rig, bench.begun(cell, folder, places(cell, count))).run(lambda waypoint: None)


def test_each_pose_has_a_series_of_setpoints_beside_readings(cell: Cell, tmp_path: Path) -> None:
    recorded(cell, rig_of(cell), tmp_path / "out")
    log = load_motion(tmp_path / "out" / "motion")
    assert log.series == ("p001_up", "p001_down", "p002_up", "p002_down")
    assert log.step_s == pytest.approx(1 / HZ, rel=0.1)
    assert log.encoder_step_rad == pytest.approx(2 * np.pi / 4096)
    np.testing.assert_allclose(log.command[-1], places(cell, 2)[-1].q, atol=1e-6)
    assert 0.01 < np.abs(log.q - log.command)[:, 2].max() < BEHIND
    speed = np.abs(np.diff(log.command, axis=0)[np.diff(log.run) == 0]).max() / log.step_s
    assert speed < 1.2 * cell.limits.speed_rad_s


def test_the_pose_is_what_was_read_not_what_was_commanded(cell: Cell, tmp_path: Path) -> None:
    rig = rig_of(cell)
    recorded(cell, rig, tmp_path / "out", 1)
    last = list(csv.DictReader((tmp_path / "out" / "poses.csv").read_text().splitlines()))[-1]
    q = np.array([float(last[f"q_{joint}"]) for joint in cell.robot.joints])
    np.testing.assert_allclose(q, rig.motor(), atol=2 * np.pi / 4096)
    assert abs(q[2] - places(cell, 1)[-1].q[2]) == pytest.approx(0.02, abs=2e-3)


def test_a_joint_that_sticks_is_noticed_and_named(cell: Cell, tmp_path: Path) -> None:
    rig = rig_of(cell)
    streamer = SetpointStreamer(bench.arm_on(rig, cell), cell.robot, 0.8, rig.clock, HZ)
    streamer.move(rig.motor() + 0.05, "p")
    rig.clock.at.append((0.3 + rig.clock.now(), lambda: rig.controller.inject(ArmFault.STALL, 2, rig.clock.now())))
    with pytest.raises(ArmError, match=r"joint_2 is at .* but was commanded to"):
        streamer.move(rig.motor() + 0.6, "p")


def test_an_interrupted_recording_goes_on_with_the_log_of_the_poses_that_are_done(cell: Cell, tmp_path: Path) -> None:
    rig = rig_of(cell)
    writer = bench.begun(cell, tmp_path / "out", places(cell, 2))
    camera = bench.Painted(rig, (24, 16), breaks_at=2)
    with pytest.raises(Interrupted):
        bench.session(cell, rig, writer, camera).run(lambda waypoint: None)
    assert load_motion(tmp_path / "out" / "motion").series == ("p001_up", "p001_down")
    bench.session(cell, rig, bench.resumed(cell, tmp_path / "out")).run(lambda waypoint: None)
    assert load_motion(tmp_path / "out" / "motion").series == ("p001_up", "p001_down", "p002_up", "p002_down")


def test_an_arm_that_plans_its_motions_itself_takes_no_setpoints(tmp_path: Path) -> None:
    made = bench.cell(tmp_path, "acl")
    with pytest.raises(DataError, match="setpoint_hz"):
        arm_class(replace(made, arm=replace(made.arm, setpoint_hz=HZ)))


def test_setpoints_start_and_end_at_rest_and_never_turn_back() -> None:
    share = np.array([smooth(t) for t in np.linspace(0.0, 1.0, 101)])
    assert (share[0], share[-1]) == (0.0, 1.0)
    assert (np.diff(share) > 0).all()
    assert np.diff(share)[[0, -1]].max() < 1e-4
