"""Counts of a decoupled SCORBOT become joint angles."""

from dataclasses import replace

import bench
import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.cell.acl import radians_per_count
from robolaser.cell.failures import ArmRestarted
from robolaser.cell.motion import Mover
from robolaser.data.cell_config import load_cell
from robolaser.errors import ArmError, DataError

A_DEGREE = 100.0


@pytest.mark.parametrize(
    ("degrees_of_motors", "joints_deg"),
    [
        ((0, 10, 0, 0, 0), (0, 10, -10, 0, 0)),  # the upper arm alone: forearm and hand keep their directions
        ((0, 0, 10, 0, 0), (0, 0, 10, -10, 0)),
        ((0, 0, 0, 10, -10), (0, 0, 0, 10, 0)),  # against each other: pitch
        ((0, 0, 0, 10, 10), (0, 0, 0, 0, 10)),  # together: roll
        ((5, 10, 20, 40, 0), (5, 10, 10, 0, 20)),
    ],
)
def test_an_er_v_plus_counts_directions_in_the_world(degrees_of_motors, joints_deg):
    q = radians_per_count("er5plus", np.full(5, 90 * A_DEGREE)) @ np.multiply(degrees_of_motors, A_DEGREE)
    np.testing.assert_allclose(np.rad2deg(q), joints_deg, atol=1e-12)


def test_an_er_vii_counts_its_joints_one_by_one():
    per_quarter = np.array([23040.0, -23040, 23040, -19200, 23040])
    np.testing.assert_array_equal(radians_per_count("er7", per_quarter), np.diag(np.pi / 2 / per_quarter))


def test_an_er_vii_that_is_taken_for_an_er_v_plus_is_not_opened(tmp_path):
    """The controller itself says the hand's pitch."""
    rig = bench.bench_for(bench.cell(tmp_path))
    with pytest.raises(ArmError, match=r"hand pitch of .* Check \[arm\] axes"):
        bench.arm_on(rig, bench.cell(tmp_path, "er5plus"))


@pytest.mark.parametrize(
    ("true", "stated", "begin"), [("er5plus", "acl", "home"), ("er5plus", "acl", "level"), ("acl", "er5plus", "level")]
)
def test_where_the_pitch_tells_nothing_yet_the_first_motion_shows_the_wrong_type(tmp_path, true, stated, begin):
    """At the reference posture all encoders of both types mean a level hand."""
    rig, cell = bench.bench_for(bench.cell(tmp_path, true)), bench.cell(tmp_path, stated)
    if begin == "level":
        said = [rig.controller.receive(b"SHOW PAR %d\r" % (52 + i), 0.0) for i in range(5)]
        stored = "".join(f"SETPV P {i} {int(one.split(b'=')[1].split()[0])}\r" for i, one in enumerate(said, 1))
        rig.controller.receive(f"DEFP P\rHERE P\r{stored}MOVE P\r".encode(), 0.0)
        rig.clock.wait(60.0)
    at = rig.motor()
    moving = Mover(bench.arm_on(rig, cell), cell.robot, 0.3, rig.clock)
    start = moving.resting("Before")
    with pytest.raises(ArmError, match=r"Check \[arm\] axes"):
        moving.move_and_wait(start + np.array([0.0, 0.5, -0.1, 0.6, 0.0]), "p", start)
    assert np.abs(rig.motor() - at).max() < 0.45  # of 0.8 that joint_4 would have gone


@pytest.mark.parametrize("seed", range(4))
def test_no_er_vii_is_doubted_wherever_it_goes_and_whatever_its_reference_is(cell, seed):
    cell = replace(cell, arm=replace(cell.arm, reference_rad=(0.0,) * 5, direction=(1.0,) * 5))
    rig = bench.bench_for(cell)
    arm, rng = bench.arm_on(rig, cell), np.random.default_rng(seed)
    for _ in range(6):
        arm.start_move(rng.uniform(0.8 * cell.robot.lower, 0.8 * cell.robot.upper), 3.0)
        for _ in range(40):
            rig.clock.wait(0.2)
            arm.read()


def test_the_type_of_a_scorbot_must_be_stated(tmp_path):
    folder = cell_folder(tmp_path)
    (folder / "cell.toml").write_text((folder / "cell.toml").read_text().replace('axes = "er7"\n', ""))
    with pytest.raises(DataError, match=r"lacks \[arm\] axes"):
        load_cell(folder)


@pytest.mark.parametrize("lines", ["SYSTEM READY !", "----ROM TEST COMPLETE.", "INSTALLING DEFAULT SETUP."])
def test_any_line_of_a_boot_says_that_the_controller_has_restarted(tmp_path, lines):
    """A disturbed line may swallow the others."""
    rig, arm = bench.armed(bench.cell(tmp_path))
    rig.coming += f"\r\n{lines}\r\n>".encode()
    with pytest.raises(ArmRestarted, match="restarted"):
        arm.poll_faults()


@pytest.mark.parametrize("answer", ["UNRECOGNIZED REQUEST", "*** ERROR 310: BAD AXIS", "POSITION IS NOT DEFINED"])
def test_what_a_controller_does_not_carry_out_is_no_success(tmp_path, answer, monkeypatch):
    rig, arm = bench.armed(bench.cell(tmp_path))
    receive = rig.controller.receive
    monkeypatch.setattr(
        rig.controller, "receive", lambda data, now_s: receive(data, now_s).replace(b"O.K.", answer.encode())
    )
    with pytest.raises(ArmError):
        arm.switch(1, on=True)
