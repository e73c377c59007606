"""Joints that follow others (mimic): what moves with them must agree with screws and with differences."""

import pickle

import numpy as np
import pytest
from screws import Screws
from test_kinematics import MIXED

from robolaser.geometry.rigid_motion import exp_so3, inverse, pose
from robolaser.robot.kinematics import Robot


def following(joint, leader, ratio, offset):
    """MIXED with a joint that follows another."""
    name = f'<joint name="{joint}" type='
    assert name in MIXED
    head, tail = MIXED.split(name)
    return f"{head}{name}{tail.replace('</joint>', f'{ratio_text(leader, ratio, offset)}</joint>', 1)}"


def ratio_text(leader, ratio, offset):
    return f'<mimic joint="{leader}" multiplier="{ratio}" offset="{offset}"/>'


ARMS = {
    "a wrist that keeps the hand level": (following("wrist", "table", -1.0, 0.4), None, ("lift", "table")),
    "a turntable driven by a rail": (following("table", "lift", 2.5, -0.3), None, ("lift", "wrist")),
    "a rail driven by a wrist beyond it": (following("lift", "wrist", 0.1, 0.05), None, ("table", "wrist")),
    "a wrist driven by a finger beside the way": (following("wrist", "finger", 0.7, 0.1), ("finger", "lift"), None),
    "a wrist that follows nobody who moves": (following("wrist", "table", -1.0, 0.4), ("lift",), None),
    "a follower with a reading of its own": (following("wrist", "table", 3.0, 1.0), ("table", "wrist"), None),
    "a thumb that follows a finger": (MIXED, ("finger", "lift", "table"), None),
}


@pytest.fixture(params=ARMS.values(), ids=ARMS.keys())
def arms(request):
    """The arm, the same by screws, and joint values (n, j)."""
    text, listed, expected = request.param
    robot = Robot.from_urdf(text, flange="flange", joints=listed)
    assert robot.joints == (listed or expected)
    q = np.random.default_rng(8).uniform(-2, 2, (5, len(robot.joints)))
    return robot, Screws(text, robot.joints), q


def test_the_flange_is_where_screws_say(arms):
    robot, screws, q = arms
    np.testing.assert_allclose(robot.forward(q[None])[0], screws.forward(q, "flange"), rtol=0, atol=1e-12)


def test_joints_bear_the_weight_that_screws_say(arms):
    robot, screws, q = arms
    np.testing.assert_allclose(robot.gravity_torques(q), screws.torques(q), rtol=0, atol=1e-12)


def test_the_flange_moves_with_each_joint_as_differences_say(arms):
    robot, screws, q = arms
    step = 1e-6
    for column, moves in enumerate(step * np.eye(q.shape[1])):
        after, before = (screws.forward(q + way * moves, "flange") for way in (1, -1))
        here = screws.forward(q, "flange")
        spin = (after - before)[:, :3, :3] @ np.swapaxes(here[:, :3, :3], 1, 2) / (2 * step)
        shift = (after - before)[:, :3, 3] / (2 * step)
        expected = np.concatenate([shift, np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)], axis=1)
        np.testing.assert_allclose(robot.jacobian(q[None])[0, :, :, column], expected, rtol=0, atol=1e-8)


def test_the_flange_moves_with_each_placement_as_differences_say(arms):
    robot, _, q = arms
    step = 1e-6
    slight = np.stack([[pose(exp_so3(way * turn), way * shift) for way in (step, -step)]
                       for shift, turn in zip(np.eye(6)[:, :3], np.eye(6)[:, 3:], strict=True)])  # fmt: skip
    motion = robot.motion(q[None], robot.placements[None, None])
    for joint in range(len(robot.joints)):
        for direction, (forth, back) in enumerate(slight):
            moved = np.repeat(robot.placements[None, None], 2, axis=0)
            moved[:, 0, joint] = moved[:, 0, joint] @ np.stack([forth, back])
            after, before = robot.forward(q[None], moved)
            rate = (after - before) @ inverse(motion.T_base_flange[0]) / (2 * step)
            expected = np.stack(
                [rate[:, 0, 3], rate[:, 1, 3], rate[:, 2, 3], rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=1
            )
            found = motion.by_placements[0, :, :, joint, direction]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_poses_are_found_again(arms):
    robot, _, q = arms
    lower, upper = np.clip(robot.range, -2.0, 2.0)
    q = lower + (upper - lower) * (q + 2.0) / 4.0
    assert robot.inverse(robot.forward(q[None])[0], q + 1e-4)[1].all()


def test_it_travels_to_another_process_and_into_a_urdf(arms):
    robot, _, q = arms
    there = pickle.loads(pickle.dumps(robot))
    assert np.array_equal(there.forward(q[None]), robot.forward(q[None]))
    assert np.array_equal(there.gravity_torques(q), robot.gravity_torques(q))
    moved = robot.placements @ pose(exp_so3(np.array([0.1, -0.2, 0.3])), np.array([0.01, 0.02, -0.03]))
    again = robot.with_placements(moved)
    expected = robot.forward(q[None], moved[None, None])
    np.testing.assert_allclose(again.forward(q[None]), expected, rtol=0, atol=1e-13)
