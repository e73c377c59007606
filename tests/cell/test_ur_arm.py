"""A Universal Robots arm whose connections are lost, or never made."""

from contextlib import closing
from pathlib import Path

import bench
import numpy as np
import pytest

from robolaser.cell.motion import Mover
from robolaser.data.cell_config import Cell
from robolaser.errors import ArmError, LineLost

ALL = {"control", "receive", "io"}


@pytest.fixture
def cell(tmp_path: Path) -> Cell:
    return bench.cell(tmp_path, "ur")


@pytest.mark.parametrize("last", sorted(ALL))
def test_what_was_connected_is_disconnected_where_the_rest_is_not(cell: Cell, last: str) -> None:
    rig = bench.bench_for(cell)
    rig.refuses = {last}
    with pytest.raises(ArmError, match="connection refused"):
        bench.arm_on(rig, cell)
    assert not rig.open


def test_nothing_stays_connected_after_its_end(cell: Cell) -> None:
    rig = bench.bench_for(cell)
    with closing(bench.arm_on(rig, cell)):
        assert rig.open == ALL
    assert not rig.open


def test_a_motion_or_output_that_is_not_taken_is_no_success(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    rig.open, rig.refuses = {"receive"}, ALL
    with pytest.raises(ArmError, match="moveJ"):
        arm.start_move(rig.motor() + 0.1, 1.0)
    with pytest.raises(ArmError, match="setStandardDigitalOut"):
        arm.switch(1, on=False)


def test_an_arm_whose_connections_break_is_stopped_over_new_ones(cell: Cell) -> None:
    rig, arm = bench.armed(cell)
    arm.switch(1, on=True)
    moving = Mover(arm, cell.robot, 0.3, rig.clock)
    home = moving.resting("Before")
    rig.clock.at.append((rig.clock.now() + 1.5, rig.open.clear))
    with pytest.raises(LineLost):
        moving.move_and_wait(home + 0.5, "p", home)
    stands = moving.halt()
    arm.switch(1, on=False)
    rig.clock.wait(30.0)
    np.testing.assert_allclose(rig.motor(), stands, atol=1e-3)
    assert np.abs(stands - home).max() < 0.45
    assert not rig.outputs(rig.clock.now())
