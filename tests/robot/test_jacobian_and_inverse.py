"""How the flange moves with the joints, and which joint values bring it somewhere."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from screws import SHIFT, Screws
from test_kinematics import CHAIN, MIXED

from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def screws_say(joints, row, point=None):
    """Jacobian (6, j) of a point that the flange carries, at one configuration: complex steps of exponentials."""
    arm = Screws(MIXED, joints)
    T, columns = arm.link("flange", row), []
    inside = np.array([0, 0, 0, 1.0]) if point is None else np.linalg.inv(T) @ np.append(point, 1.0)
    for step in 1j * SHIFT * np.eye(len(joints)):
        slope = arm.link("flange", row + step).imag / SHIFT
        turn = slope[:3, :3] @ T[:3, :3].T
        columns.append([*(slope @ inside)[:3], turn[2, 1], turn[0, 2], turn[1, 0]])
    return np.array(columns).T


def test_the_flange_moves_with_the_joints_as_screws_say(rng):
    q = rng.uniform(-2, 2, (2, 4, 3))
    found = Robot.from_urdf(MIXED, flange="flange").jacobian(q)
    expected = [[screws_say(CHAIN, row) for row in rows] for rows in q]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_a_point_on_the_flange_moves_with_the_joints_as_screws_say(rng):
    q, points = rng.uniform(-2, 2, (1, 4, 3)), rng.normal(size=(1, 4, 3))
    found = Robot.from_urdf(MIXED, flange="flange").jacobian(q, points)
    expected = [[screws_say(CHAIN, row, point) for row, point in zip(q[0], points[0], strict=True)]]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_columns_follow_the_listed_order_and_a_finger_beside_the_flange_does_not_move_it(rng):
    listed = ("finger", "wrist", "lift", "table")
    q = rng.uniform(-2, 2, (1, 3, 4))
    found = Robot.from_urdf(MIXED, flange="flange", joints=listed).jacobian(q)
    np.testing.assert_allclose(found[0], [screws_say(listed, row) for row in q[0]], rtol=0, atol=1e-12)
    assert not found[..., 0].any()


@pytest.mark.parametrize("name", ["ur5e", "scorbot_er7"])
def test_nearly_all_poses_that_an_arm_takes_are_reached_within_its_limits(name, rng):
    robot = find_robot(name)
    lower, upper = robot.range
    goals = robot.forward(rng.uniform(lower, upper, (1, 40, len(lower))))[0]
    q, reached = robot.inverse(goals)
    assert reached.mean() > 0.9
    assert ((q >= lower) & (q <= upper)).all()
    off = np.linalg.inv(goals[reached]) @ robot.forward(q[None, reached])[0]
    assert np.abs(off[:, :3, 3]).max() < 1e-8
    assert Rotation.from_matrix(off[:, :3, :3]).magnitude().max() < 1e-8


def test_one_pose_gives_one_row(rng):
    robot = find_robot("ur5e")
    T = robot.forward(rng.uniform(-1.0, 1.0, 6))
    every, reached = robot.inverse(T[None])
    np.testing.assert_array_equal(robot.inverse(T)[0], every[0])
    assert robot.inverse(T, every[0])[1] == reached[0]


def test_a_start_near_a_solution_leads_to_that_one(rng):
    robot = find_robot("ur5e")
    q = rng.uniform(-1.5, 1.5, (20, 6))
    found, reached = robot.inverse(robot.forward(q[None])[0], q + 1e-3 * rng.normal(size=q.shape))
    near = np.abs(found - q).max(axis=1) < 0.05
    assert reached.all()
    assert near.mean() > 0.9  # the others stand near a singular posture, where two solutions meet


def test_a_pose_out_of_reach_is_said_to_be_so_and_the_others_are_reached():
    robot = find_robot("ur5e")
    goals = np.repeat(robot.forward(np.array([[[0.3, -1.2, 1.5, 0.4, 0.8, 0.1]]]))[0], 2, axis=0)
    goals[1, 0, 3] += 3.0
    assert robot.inverse(goals)[1].tolist() == [True, False]
