"""The SCORBOT's controller, heard right whatever the line does to it."""

import bench
import numpy as np
import pytest

from robolaser.cell.acl import PLACES, AclArm
from robolaser.cell.failures import AnswerUnclear, ArmAlarm, ArmRestarted
from robolaser.cell.motion import Mover
from robolaser.cell.serial_line import SerialLine
from robolaser.data.cell_config import Cell
from robolaser.errors import ArmError, DataError, LineLost
from robolaser.robot.by_name import find_robot


def test_the_arm_takes_the_time_that_it_is_given(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    home = rig.motor()
    arm.start_move(home + 0.5, 4.0)
    began = rig.clock.now()
    while np.abs(rig.motor() - home - 0.5).max() > 2e-4:
        rig.clock.wait(0.01)
    assert 3.8 < rig.clock.now() - began < 4.2


def test_a_command_left_half_typed_is_not_carried_out(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    bench.arm_on(rig, cell).start_move(rig.motor() + 0.2, 1.0)
    rig.clock.wait(20.0)
    there = rig.motor()
    SerialLine(rig, "bench", rig.clock).send(f"SETPV {PLACES[0]} 1 0\rMOVE {PLACES[0]}")
    bench.arm_on(rig, cell)
    rig.clock.wait(60.0)
    np.testing.assert_array_equal(rig.motor(), there)


def test_no_word_that_is_misheard_takes_effect(cell: Cell) -> None:
    wrong = 0
    for seed in range(12):
        rig = bench.bench_for(cell, ["misheard:0.04@60-100000"], seed)
        home = rig.motor()
        goal = home + 0.2
        try:
            bench.arm_on(rig, cell).start_move(goal, 2.0)
        except (AnswerUnclear, LineLost):
            wrong += 1
        rig.clock.wait(30.0)
        there = rig.motor()
        assert np.abs(there - home).max() < 1e-3 or np.abs(there - goal).max() < 1e-3, seed
    assert wrong < 6


def test_an_answer_that_comes_late_is_not_taken_for_the_next(cell: Cell) -> None:
    rig = bench.bench_for(cell, ["late:1.4@50-400"])
    mover = Mover(bench.arm_on(rig, cell), cell.description.robot, 0.3, rig.clock)
    at = mover.resting("Before")
    for step in (0.1, -0.1, 0.2):
        at = mover.move_and_wait(at + step, "p", at)
        np.testing.assert_allclose(at, rig.motor(), atol=1e-9)


def test_an_arm_whose_motors_are_off_refuses(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    rig.controller._controller._disabled = {1, 2, 3, 4, 5}
    with pytest.raises(ArmError, match=r"304.*switch the motors on"):
        arm.start_move(rig.motor() + 0.1, 1.0)


def test_a_stop_that_is_not_heard_is_said_again(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    rig, arm = bench.armed(cell)
    mover = Mover(arm, cell.description.robot, 0.3, rig.clock)
    arm.start_move(rig.motor() + 0.5, 60.0)
    rig.clock.wait(10.0)
    stops: list[bytes] = []
    hear = rig.controller.receive

    def hard_of_hearing(data: bytes, now_s: float) -> bytes:
        if set(data) == {1}:
            stops.append(data)
            return hear(data, now_s) if len(stops) > 2 else b""
        return hear(data, now_s)

    monkeypatch.setattr(rig.controller, "receive", hard_of_hearing)
    mover.halt()
    there = rig.motor()
    rig.clock.wait(60.0)
    assert len(stops) == 3
    np.testing.assert_array_equal(rig.motor(), there)


def test_homing_ends_at_home(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    home = rig.motor()
    arm = bench.arm_on(rig, cell)
    arm.start_move(home + 0.3, 1.0)
    rig.clock.wait(20.0)
    arm.home()
    np.testing.assert_allclose(arm.read(), home, atol=1e-3)
    np.testing.assert_allclose(rig.motor(), home, atol=1e-3)


def test_a_home_that_is_not_found_is_named(cell: Cell) -> None:
    arm = bench.arm_on(bench.bench_for(cell, ["homing:3"]), cell)
    with pytest.raises(ArmError, match="axis 3"):
        arm.home()


def test_a_line_that_is_cut_while_homing_is_noticed(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    arm._line._transport = bench.Bench(rig.controller, rig.clock, ["silent@>20s"])
    with pytest.raises(LineLost, match="during homing"):
        arm.home()
    assert rig.clock.now() < 20.0 + 5.0


@pytest.mark.parametrize(
    ("fault", "error"), [("impact:3", ArmAlarm), ("thermic:2", ArmAlarm), ("reboot", ArmRestarted)]
)
def test_what_befalls_an_arm_that_searches_its_home_is_heard(cell: Cell, fault: str, error: type[Exception]) -> None:
    rig, arm = bench.armed(cell, [f"{fault}@>30s"])
    with pytest.raises(error):
        arm.home()
    assert rig.clock.now() < 35.0


def test_an_arm_that_will_not_search_its_home_says_why(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    rig.controller._controller._disabled = {1, 2, 3, 4, 5}
    began = rig.clock.now()
    with pytest.raises(ArmError, match=r"'HOME'.*304"):
        arm.home()
    assert rig.clock.now() - began < 5.0


def test_what_is_refused_each_time_with_the_same_words_is_no_disturbed_line(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    with pytest.raises(ArmError, match=r"'SET OUT\[99\]=1' with '\*\*\* BAD OUTPUT 99'"):
        bench.arm_on(rig, cell).switch(99, on=True)


def test_noise_that_looks_like_the_first_prompt_is_no_restart(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    for noise in (b"x>_", b"\r\n>_", b"READY", b"SYSTEM\r\n>"):
        rig.coming += noise
        arm.poll_faults()
        np.testing.assert_allclose(arm.read(), rig.motor(), atol=1e-9)


def test_a_controller_without_echo_is_asked_for_it(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    rig.controller._controller._echo = False
    np.testing.assert_allclose(bench.arm_on(rig, cell).read(), rig.motor(), atol=1e-12)


def test_a_robot_with_more_joints_than_axes_is_refused(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    with pytest.raises(DataError, match="up to 5"):
        AclArm(SerialLine(rig, "bench", rig.clock), cell.arm, find_robot("ur10"))


def test_a_parameter_without_sense_is_named(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    rig.controller._controller._encoders.par[34] = 0
    with pytest.raises(ArmError, match="PAR 34 = 0"):
        bench.arm_on(rig, cell)
