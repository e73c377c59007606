"""Counts of a decoupled SCORBOT become joint angles."""

from pathlib import Path

import bench
import numpy as np
import pytest

from robolaser.cell.acl_axes import radians_per_count
from robolaser.cell.failures import AnswerUnclear, ArmRefused, ArmRestarted
from robolaser.errors import ArmError

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
def test_an_er_v_plus_counts_directions_in_the_world(
    degrees_of_motors: tuple[float, ...], joints_deg: tuple[float, ...]
) -> None:
    per_quarter = np.full(5, 90 * A_DEGREE)
    q = radians_per_count("er5plus", per_quarter) @ np.multiply(degrees_of_motors, A_DEGREE)
    np.testing.assert_allclose(np.rad2deg(q), joints_deg, atol=1e-12)


def test_an_er_vii_counts_its_joints_one_by_one() -> None:
    per_quarter = np.array([23040.0, -23040, 23040, -19200, 23040])
    np.testing.assert_array_equal(radians_per_count("er7", per_quarter), np.diag(np.pi / 2 / per_quarter))


def test_an_er_vii_that_is_taken_for_an_er_v_plus_is_not_opened(tmp_path: Path) -> None:
    """The controller itself says the hand's pitch."""
    rig = bench.bench_for(bench.cell(tmp_path))
    rig.controller.receive(b"DEFP P\rHERE P\rSETPV P 2 4000\rMOVE P\r", 0.0)
    rig.clock.wait(60.0)
    with pytest.raises(ArmError, match=r"pitch is .* Check \[arm\] axes"):
        bench.arm_on(rig, bench.cell(tmp_path, "er5plus"))


@pytest.mark.parametrize("lines", ["SYSTEM READY !", "----ROM TEST COMPLETE.", "INSTALLING DEFAULT SETUP."])
def test_any_line_of_a_boot_says_that_the_controller_has_restarted(tmp_path: Path, lines: str) -> None:
    """A disturbed line may swallow the others."""
    cell = bench.cell(tmp_path)
    rig = bench.bench_for(cell)
    arm = bench.arm_on(rig, cell)
    rig.coming += f"\r\n{lines}\r\n>".encode()
    with pytest.raises(ArmRestarted, match="restarted"):
        arm.poll_faults()


@pytest.mark.parametrize("answer", ["UNRECOGNIZED REQUEST", "*** ERROR 310: BAD AXIS", "POSITION IS NOT DEFINED"])
def test_what_a_controller_does_not_carry_out_is_no_success(
    tmp_path: Path, answer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = bench.cell(tmp_path)
    rig = bench.bench_for(cell)
    arm = bench.arm_on(rig, cell)
    receive = rig.controller.receive
    monkeypatch.setattr(
        rig.controller, "receive", lambda data, now_s: receive(data, now_s).replace(b"O.K.", answer.encode())
    )
    with pytest.raises((AnswerUnclear, ArmRefused)):
        arm.laser_on(1)
