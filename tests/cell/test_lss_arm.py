"""Smart servos on one line: those that do not hear, and packets as their makers print them."""

import re
from contextlib import suppress
from pathlib import Path

import bench
import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.cell.failures import AnswerUnclear, ArmAlarm
from robolaser.cell.lss import LssArm
from robolaser.cell.motion import Mover
from robolaser.cell.serial_line import SerialLine
from robolaser.cell.servos import READ_ALL, WRITE_ALL, Feetech, crc16
from robolaser.data.cell_config import Cell, load_cell
from robolaser.emulator.emulated_cell import controller_of
from robolaser.errors import ArmError, LineLost
from robolaser.robot.by_name import find_robot

STEP = np.deg2rad(0.1)


@pytest.fixture
def cell(tmp_path: Path) -> Cell:
    return bench.cell(tmp_path, "lss")


def test_a_servo_that_is_not_there_is_named_within_two_seconds(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    arm = cell.arm.__class__(kind="lss", port="bench")
    began = rig.clock.now()
    with pytest.raises(LineLost, match=r"servo 6 \(wrist_3"):
        LssArm(SerialLine(rig, "bench", rig.clock), arm, find_robot("ur10"))
    assert rig.clock.now() - began < 2.5


@pytest.mark.parametrize(("fault", "said"), [("impact:3", "blocked"), ("thermic:2", "safe mode")])
def test_a_servo_in_trouble_is_named(cell: Cell, fault: str, said: str) -> None:
    rig = bench.bench_for(cell, [f"{fault}@>0.6s"])
    mover = Mover(bench.arm_on(rig, cell), cell.description.robot, 0.3, rig.clock)
    at = mover.resting("Before")
    with pytest.raises(ArmAlarm, match=rf"{said}.*joint_{fault[-1]}"):
        mover.move_and_wait(at + 0.5, "p", at)


def test_a_goal_that_is_misheard_is_told_again_or_nobody_moves(cell: Cell) -> None:
    went = 0
    for seed in range(20):
        rig = bench.bench_for(cell, ["misheard:0.01"], seed)
        home = rig.motor()
        try:
            bench.arm_on(rig, cell).start_move(home + 0.5, 5.0)
        except (AnswerUnclear, LineLost):
            rig.clock.wait(30.0)
            assert np.abs(rig.motor() - home).max() < 0.02, seed
            continue
        went += 1
        rig.clock.wait(30.0)
        assert np.abs(rig.motor() - home - 0.5).max() < STEP
    assert went > 12


def test_a_time_that_is_misheard_makes_no_servo_faster_than_it_may_be(cell: Cell) -> None:
    """The time cannot be read back; the cap on the speed can."""
    rig = bench.bench_for(cell)
    hear = rig.controller.receive
    rig.controller.receive = lambda data, now_s: hear(re.sub(rb"T\d+", b"T1", data), now_s)
    mover = Mover(bench.arm_on(rig, cell), cell.robot, 0.3, rig.clock)
    at = mover.resting("Before")
    watched = bench.Watched(rig, 0.3)
    with suppress(ArmError):
        mover.move_and_wait(at + np.array([0.5, 0.1, -0.4, 0.2, 0.3]), "p", at)
    assert watched.fastest() < 1.05 * 0.3


def test_a_servo_that_was_switched_on_anew_is_capped_again(cell: Cell) -> None:
    rig, arm = bench.armed(cell, ["reboot@>4s"])
    arm.start_move(rig.motor() + 0.1, 2.0)
    rig.clock.wait(8.0)
    assert not rig.in_waiting  # the power fails when somebody looks
    rig.clock.wait(2.0)
    rig.sent = b""
    arm.start_move(rig.motor() + 0.2, 4.0)
    assert rig.sent.count(b"SD54\r") == 5  # 1.875 times 11.46 degrees in 4 s


def test_servos_switch_no_laser(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    with pytest.raises(ArmError, match=r"\[laser\]"):
        bench.arm_on(rig, cell).switch(1, on=True)


@pytest.mark.parametrize("kind", ["dynamixel", "feetech"])
def test_a_stop_that_no_servo_heard_is_said(tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rig, arm = bench.armed(bench.cell(tmp_path, kind))
    arm.start_move(rig.motor() + np.array([0.4, 0.2, 0.1, 0.3, -0.2]), 4.0)
    rig.clock.wait(1.0)
    receive, code = rig.controller.receive, 7 if kind == "dynamixel" else 4
    deaf = [True]
    monkeypatch.setattr(
        rig.controller,
        "receive",
        lambda data, now_s: b"" if deaf[0] and data[code] == WRITE_ALL else receive(data, now_s),
    )
    with pytest.raises(AnswerUnclear, match="stop at"):
        arm.stop()
    deaf[0] = False
    arm.stop()
    stands = rig.motor()
    rig.clock.wait(10.0)
    np.testing.assert_allclose(rig.motor(), stands, atol=2e-3)


@pytest.mark.parametrize(
    "packet",
    [
        "FF FF FD 00 01 03 00 01 19 4E",  # ping
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",  # read the present position
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",  # its answer
    ],
)
def test_the_crc_is_that_of_the_e_manual(packet: str) -> None:
    *data, low, high = bytes.fromhex(packet)
    assert crc16(bytes(data)) == low + 256 * high


def test_a_sync_read_is_that_of_the_feetech_manual() -> None:
    assert Feetech().instruction(READ_ALL, bytes.fromhex("38 08 01 02")).hex(" ") == "ff ff fe 06 82 38 08 01 02 36"


def test_an_emulated_servo_answers_what_the_manual_asks(tmp_path: Path) -> None:
    servos = controller_of(load_cell(cell_folder(tmp_path, "feetech")))
    answers = servos.receive(bytes.fromhex("FF FF FE 06 82 38 08 01 02 36"), 0.0)
    assert answers[:14].hex(" ") == "ff ff 01 0a 00 00 08 00 00 00 00 00 00 ec"
    assert answers[14:].hex(" ") == "ff ff 02 0a 00 00 08 00 00 00 00 00 00 eb"
