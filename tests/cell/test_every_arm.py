"""What every arm promises, whatever its controller's language."""

from pathlib import Path

import bench
import numpy as np
import pytest
from emulated_cell import ARMS as EMULATED
from fake_ur import UrRig

from robolaser.cell.arm import ARMS as KINDS
from robolaser.cell.failures import ArmAlarm
from robolaser.cell.motion import Mover
from robolaser.data.cell_config import Cell
from robolaser.errors import LineLost

WIRED = sorted(EMULATED)
Rig = bench.Bench | UrRig
PLUGGED_S, NOTICED_S = 2.5, 2.0


@pytest.fixture(params=WIRED)
def cell(request: pytest.FixtureRequest, tmp_path: Path) -> Cell:
    return bench.cell(tmp_path, request.param)


def mover(rig: Rig, cell: Cell) -> Mover:
    return Mover(bench.arm_on(rig, cell), cell.description.robot, 0.3, rig.clock)


def test_every_kind_of_arm_is_held_to_these_promises() -> None:
    assert {bench.kind_of(name) for name in WIRED} == set(KINDS) - {"replay"}


def test_opening_moves_nothing(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    home = rig.motor()
    bench.arm_on(rig, cell)
    rig.clock.wait(60.0)
    np.testing.assert_array_equal(rig.motor(), home)


def test_it_reads_what_the_motors_do(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    arm.start_move(rig.motor() + np.array([0.3, -0.2, 0.1, 0.25, -0.4]), 5.0)
    for _ in range(20):
        rig.clock.wait(0.5)
        before = rig.motor()
        q = arm.read()
        low, high = np.minimum(before, rig.motor()), np.maximum(before, rig.motor())
        assert ((q >= low - 0.51 * arm.step) & (q <= high + 0.51 * arm.step)).all()


def test_it_goes_where_it_is_sent(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    moving = mover(rig, cell)
    at = moving.resting("Before")
    for offset in ([0.3, -0.2, 0.1, 0.25, -0.4], [-0.2, 0.2, -0.1, 0.0, 1.0], [0.0] * 5, [1e-4] * 5):
        goal = at + offset
        at = moving.move_and_wait(goal, "p", at)
        assert np.abs(at - goal).max() <= moving.near.max()
        assert np.abs(rig.motor() - at).max() <= 1e-3


def test_it_stops_on_the_way(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    moving = mover(rig, cell)
    home = moving.resting("Before")

    def by_hand() -> None:
        raise KeyboardInterrupt

    rig.clock.at.append((rig.clock.now() + 1.5, by_hand))
    with pytest.raises(KeyboardInterrupt):
        moving.move_and_wait(home + 0.5, "p", home)
    stands = moving.halt()
    rig.clock.wait(30.0)
    np.testing.assert_allclose(rig.motor(), stands, atol=1e-3)
    assert np.abs(stands - home).max() < 0.45


def test_an_arm_whose_computer_dies_stops_within_a_second(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    moving = mover(rig, cell)
    home = moving.resting("Before")

    def dies() -> None:
        raise SystemExit

    rig.clock.at.append((rig.clock.now() + 2.3, dies))
    with pytest.raises(SystemExit):
        moving.move_and_wait(home + 1.0, "p", home)
    rig.clock.wait(1.0)
    stands = rig.motor()
    rig.clock.wait(60.0)
    np.testing.assert_array_equal(rig.motor(), stands)
    assert 0.02 < np.abs(stands - home).max() < 0.9


@pytest.mark.parametrize("fault", ["silent", "cut", "lost:1", "late:60"])
def test_a_lost_line_is_noticed_within_two_seconds(cell: Cell, fault: str) -> None:
    rig = bench.bench_for(cell, [f"{fault}@>{PLUGGED_S}s"])
    moving = mover(rig, cell)
    home = moving.resting("Before")
    with pytest.raises(LineLost):
        moving.move_and_wait(home + 0.5, "p", home)
    assert rig.clock.now() < PLUGGED_S + NOTICED_S + 0.3  # and the time of what was being said


@pytest.mark.parametrize("fault", ["impact:2", "thermic:4"])
def test_a_joint_in_trouble_is_named(cell: Cell, fault: str) -> None:
    moving = mover(bench.bench_for(cell, [f"{fault}@>3s"]), cell)
    home = moving.resting("Before")
    with pytest.raises(ArmAlarm, match=f"joint_{fault[-1]}"):
        moving.move_and_wait(home + 0.5, "p", home)
