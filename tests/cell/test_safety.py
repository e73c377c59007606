"""Limits are kept at every pose and on all the way between."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import bench
import numpy as np
import pytest
from emulated_cell import ARMS

from robolaser.arrays import Array
from robolaser.cell.clock import PEAK, seconds_for
from robolaser.cell.failures import NotSettled
from robolaser.cell.motion import Mover
from robolaser.cell.plan_validation import RouteCheck, lowest, reach, tool_points
from robolaser.data.cell_config import Cell, Limits
from robolaser.errors import ArmError, PlanError
from robolaser.geometry.rigid_motion import apply
from robolaser.robot.by_name import find_robot
from robolaser.robot.collisions import CollisionModel

ROBOT = find_robot("scorbot_er7")
NONE = np.empty((0, 3))
HOME = np.array([0.0, -0.4, 0.6, 0.0, 0.0])


def violations(limits: Limits, start: Array | None, names: Sequence[str], q: Array) -> list[str]:
    """Of an arm that carries nothing and hits nothing."""
    return RouteCheck(ROBOT, limits, NONE, CollisionModel(ROBOT, [])).violations(start, names, q)


def test_a_route_within_all_limits_breaks_none() -> None:
    q = HOME + np.random.default_rng(2).uniform(-0.1, 0.1, (10, 5))
    assert not violations(Limits(floor_m=0.05, reach_m=0.9), HOME, [str(i) for i in range(10)], q)


def test_every_pose_beyond_a_joints_limit_is_named() -> None:
    q = np.tile(HOME, (3, 1))
    q[1, 2] = ROBOT.upper[2] + 0.1
    q[2, 0] = ROBOT.lower[0] - 0.1
    found = violations(Limits(), HOME, ["a", "b", "c"], q)
    at_poses = [one.split(" at ")[0] for one in found if not one.startswith("on the way to ")]
    assert at_poses == ["b: joint_3", "c: joint_1"]
    assert "limit 112.50°" in found[0]


def test_a_dip_below_the_floor_on_the_way_is_found() -> None:
    """Two postures that stand high, the straight way between which passes low."""
    a, b = np.random.default_rng(5).uniform(ROBOT.lower, ROBOT.upper, (2, 4000, 5))
    share = np.linspace(0, 1, 30)[:, None, None]
    heights = np.array([lowest(ROBOT, place, NONE) for place in a + share * (b - a)])
    ends = np.minimum(heights[0], heights[-1])
    dips = np.flatnonzero(heights.min(axis=0) < ends - 0.1)
    assert len(dips) > 20
    for i in dips[:20]:
        floor = float(heights[:, i].min() + ends[i]) / 2
        (found,) = violations(Limits(floor_m=floor), a[i], ["p"], b[i : i + 1])
        assert found.startswith("on the way to p: the lowest part at ")


def test_the_sensor_on_the_flange_counts(tmp_path: Path) -> None:
    tools = tool_points(bench.cell(tmp_path).description)
    assert tools.shape == (2, 3)
    np.testing.assert_allclose(np.linalg.norm(tools[1] - tools[0]), 0.14)
    q = np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (200, 5))
    heights = apply(ROBOT.forward(q[None])[0][:, None], tools[None])[..., 2].min(axis=1)
    np.testing.assert_allclose(lowest(ROBOT, q, tools), np.minimum(lowest(ROBOT, q, NONE), heights))
    assert (lowest(ROBOT, q, tools) < lowest(ROBOT, q, NONE)).any()


def test_too_far_is_too_far() -> None:
    q = np.zeros((1, 5))
    far = float(reach(ROBOT, q)[0])
    assert not violations(Limits(reach_m=far + 0.01), None, ["p"], q)
    (found,) = violations(Limits(reach_m=far - 0.01), None, ["p"], q)
    assert found.startswith("p: the flange at ")


def test_postures_that_are_allowed_break_nothing(tmp_path: Path) -> None:
    cell = replace(bench.cell(tmp_path), limits=Limits(floor_m=0.1, reach_m=0.6, margin_m=0.05))
    q = np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (300, 5))
    check = RouteCheck.of(cell)
    may = check.allows(q, 0.05)
    assert 5 < may.sum() < 295
    for good, row in zip(may, q, strict=True):
        ways = [check.violations(None, ["p"], (row + d)[None]) for d in (-0.05, 0.0, 0.05)]
        assert good == (not any(ways)) or np.abs([row - ROBOT.lower, ROBOT.upper - row]).min() < 0.06


@pytest.mark.parametrize("kind", sorted(ARMS))
@pytest.mark.parametrize("speed", [0.03, 0.3])
def test_no_joint_ever_exceeds_its_speed_nor_a_piece_its_time(tmp_path: Path, kind: str, speed: float) -> None:
    """Even where the controller's profile has the highest peak: emulated ones peak at 4 / 3 of the mean."""
    cell = bench.cell(tmp_path, kind)
    rig, arm = bench.armed(cell)
    mover = Mover(arm, cell.robot, speed, rig.clock)
    at = mover.resting("Before")
    start, given = arm.start_move, list[float]()
    arm.start_move = lambda q, seconds: (given.append(seconds), start(q, seconds))[1]
    watched = bench.Watched(rig, 0.1)
    mover.move_and_wait(at + np.multiply([0.1, -0.06, 0.04, 0.02, 0.1], 1 + 4 * (speed > 0.1)), "p", at)
    assert 0.5 * speed < watched.fastest() < 1.01 * speed * 4 / 3 / PEAK
    assert max(given) <= cell.arm.unattended_s


def test_a_speed_that_the_encoders_cannot_follow_is_refused(tmp_path: Path) -> None:
    cell = bench.cell(tmp_path, "lss")
    rig = bench.bench_for(cell)
    with pytest.raises(PlanError, match=r"speed_rad_s: 0.005 is too slow .* State 0.026 or more"):
        Mover(bench.arm_on(rig, cell), cell.robot, 0.005, rig.clock)


def test_time_grows_with_the_way_and_shrinks_with_the_speed() -> None:
    way = np.array([0.1, -3.0])
    assert seconds_for(way, 0.3) == pytest.approx(PEAK * 10.0)
    assert seconds_for(2 * way, 0.6) == pytest.approx(seconds_for(way, 0.3))
    assert seconds_for(0 * way, 0.3) > 0


def test_an_arm_that_sticks_is_not_taken_for_one_that_arrived(cell: Cell) -> None:
    rig = bench.bench_for(cell, ["stall:2@>4s"])
    mover = Mover(bench.arm_on(rig, cell), ROBOT, 0.3, rig.clock)
    at = mover.resting("Before")
    with pytest.raises(ArmError, match="On the way to p, joint_2 stands still"):
        mover.move_and_wait(at + np.array([0.0, 0.5, 0.0, 0.0, 0.0]), "p", at)


@pytest.mark.parametrize("joint", [1, 2, 5])
def test_a_joint_that_does_not_keep_step_with_the_others_is_noticed(cell: Cell, joint: int) -> None:
    rig = bench.bench_for(cell, [f"stall:{joint}@>4s"])
    mover = Mover(bench.arm_on(rig, cell), ROBOT, 0.3, rig.clock)
    at = mover.resting("Before")
    with pytest.raises(ArmError, match=rf"joint_{joint} is at .* off the straight path"):
        mover.move_and_wait(at + 0.5, "p", at)
    mover.halt()
    assert np.ptp(rig.motor() - at) < np.deg2rad(8.0)


def test_a_joint_that_stands_still_while_others_go_on_is_noticed(cell: Cell) -> None:
    """Its way is so short that it is never far off."""
    rig = bench.bench_for(cell, ["stall:4@>2s"])
    mover = Mover(bench.arm_on(rig, cell), ROBOT, 0.1, rig.clock)
    at = mover.resting("Before")
    began = rig.clock.now()
    with pytest.raises(ArmError, match="joint_4 stands still"):
        mover.move_and_wait(at + np.array([1.0, 0.0, 0.0, 0.03, 0.0]), "p", at)
    assert rig.clock.now() - began < 15.0


def test_an_arm_that_goes_elsewhere_is_noticed(tmp_path: Path) -> None:
    rig, arm = bench.armed(bench.cell(tmp_path))
    mover = Mover(arm, ROBOT, 0.3, rig.clock)
    at = mover.resting("Before")
    go = arm.start_move
    arm.start_move = lambda q, seconds: go(2 * at - q, seconds)
    with pytest.raises(ArmError, match="off the straight path"):
        mover.move_and_wait(at + 0.5, "p", at)
    assert np.abs(rig.motor() - at).max() < 0.15


def test_an_arm_that_moves_by_itself_is_not_at_rest(tmp_path: Path) -> None:
    rig, arm = bench.armed(bench.cell(tmp_path))
    arm.start_move(HOME + 1.0, 20.0)
    rig.clock.wait(6.0)
    with pytest.raises(NotSettled, match="Before its first motion, joint_"):
        Mover(arm, ROBOT, 0.3, rig.clock).resting("Before its first motion")
