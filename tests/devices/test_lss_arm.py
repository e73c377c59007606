"""Smart servos on one line."""

from pathlib import Path

import bench
import numpy as np
import pytest

from robolaser.cell import Cell
from robolaser.devices.arriving import Mover
from robolaser.devices.line import Line
from robolaser.devices.lss import STEP, Lss
from robolaser.errors import ArmAlarm, ArmRefused, LineLost


@pytest.fixture
def cell(tmp_path: Path) -> Cell:
    return bench.cell(tmp_path, "lss")


def test_angles_are_the_motors_to_half_a_step(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    arm = bench.arm_on(rig, cell)
    goal = rig.motor() + np.array([0.3, -0.2, 0.1, 0.25, -0.4])
    arm.go(goal, 2.0)
    rig.clock.wait(30.0)
    assert np.abs(rig.motor() - goal).max() <= 0.51 * STEP
    np.testing.assert_allclose(arm.read(), rig.motor(), atol=0.51 * STEP)


def test_a_servo_that_is_not_there_is_named_within_two_seconds(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    ghosts = ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6"]
    arm = cell.arm.__class__(kind="lss", port="bench")
    began = rig.clock.now()
    with pytest.raises(LineLost, match=r"servo 6 \(joint_6\)"):
        Lss(Line(rig, "bench", rig.clock), arm, ghosts)
    assert rig.clock.now() - began < 2.5


@pytest.mark.parametrize(("fault", "said"), [("impact:3", "blocked"), ("thermic:2", "safe mode")])
def test_a_servo_in_trouble_is_named(cell: Cell, fault: str, said: str) -> None:
    rig = bench.bench_for(cell, [f"{fault}@>0.6s"])
    mover = Mover(bench.arm_on(rig, cell), cell.description.robot, 0.3, rig.clock)  # type: ignore[arg-type]
    at = mover.resting("Before")
    with pytest.raises(ArmAlarm, match=rf"{said}.*joint_{fault[-1]}"):
        mover.travel(at + 0.5, "p", at)


def test_a_goal_that_is_misheard_is_told_again(cell: Cell) -> None:
    for seed in range(10):
        rig = bench.bench_for(cell, ["misheard:0.02"], seed)
        home = rig.motor()
        try:
            bench.arm_on(rig, cell).go(home + 0.5, 1.0)
        except LineLost:
            continue
        rig.clock.wait(30.0)
        assert np.abs(rig.motor() - home - 0.5).max() < STEP


def test_servos_switch_no_laser(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    with pytest.raises(ArmRefused, match=r"take \[laser\] out"):
        bench.arm_on(rig, cell).light(1)
