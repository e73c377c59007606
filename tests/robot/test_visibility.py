from dataclasses import replace

import numpy as np
import pytest

from robolaser.errors import DependencyMissing, RobotError
from robolaser.geometry.rigid_motion import apply, exp_so3, from_quaternion, inverse, pose
from robolaser.robot.by_name import find_robot
from robolaser.robot.inverse_kinematics import reaching, touching, within_reach
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, limits, random_configurations
from robolaser.robot.visibility import MARGIN, TILT, View, configurations_looking_down
from robolaser.simulation.nominal import IMAGE_PX, facing_outward, scanner


@pytest.fixture(scope="module")
def robot() -> Robot:
    return find_robot("scorbot_er7")


def view_of(robot: Robot, stripe_axis: str) -> View:
    bracket = facing_outward(robot)
    values = {name: item.nominal for name, item in scanner(bracket).items()}
    shift = np.array([values[f"t_{axis}"] for axis in "xyz"])
    return View(pose(from_quaternion(np.array(bracket)), shift), values, stripe_axis, IMAGE_PX)


@pytest.mark.parametrize("stripe_axis", ["u", "v"])
def test_the_stripe_shows_where_sheet_target_and_ray_meet(robot: Robot, stripe_axis: str) -> None:
    view = view_of(robot, stripe_axis)
    T = pose(exp_so3(np.array([[np.pi - 0.2, 0.1, 0.3]])), np.array([[0.4, 0.1, 0.33]]))
    at = np.linspace(*view.stripe_range(), 7)[None]
    pixel = view.stripe(T, 0.02, at)
    np.testing.assert_allclose(pixel[..., view.along], at, atol=1e-9)
    v = view.values
    u, w = (pixel[0, :, 0] - v["u_0"]) * v["s_u"], (pixel[0, :, 1] - v["v_0"]) * v["s_v"]
    x, y = (w, -u) if stripe_axis == "u" else (u, w)
    ray = np.stack([x, y, np.full(7, v["f"])], axis=-1)
    on_sheet = ray * (v["b"] / (x + v["f"] * np.tan(v["theta"])))[:, None]
    np.testing.assert_allclose(apply(T, on_sheet)[:, 2], 0.02, atol=1e-12)


@pytest.mark.parametrize("stripe_axis", ["u", "v"])
def test_planned_postures_look_down_and_hold_the_stripe(robot: Robot, stripe_axis: str) -> None:
    view = view_of(robot, stripe_axis)
    q, level = configurations_looking_down(robot, view, wanted=10, rng=np.random.default_rng(1))
    assert len(q) >= 10
    assert level == 0.0
    T = robot.forward(q[None])[0] @ view.T_flange_camera
    assert (np.degrees(np.arccos(-T[:, 2, 2])) <= np.degrees(TILT)).all()
    at = np.broadcast_to(np.linspace(*view.stripe_range(), 9), (len(q), 9))
    assert view.contains(view.stripe(T, level, at), MARGIN * 0.99).all()
    assert ((q > robot.lower) & (q < robot.upper)).all()


def test_a_target_out_of_sight_is_said_so_with_what_was_tried(robot: Robot) -> None:
    view = view_of(robot, "u")
    view = replace(view, values={**view.values, "v_0": 1e5})
    with pytest.raises(RobotError, match=r"3 poses .* 0 found.*z = 0 m"):
        configurations_looking_down(robot, view, wanted=3, rng=np.random.default_rng(1))


def test_limits_keep_inside_and_tame_joints_that_turn_for_ever() -> None:
    urdf = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="spin" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
      <joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
        <limit lower="0.1" upper="0.3" effort="1" velocity="1"/></joint></robot>"""
    robot = Robot.from_urdf(urdf, flange="c")
    lower, upper = limits(robot)
    assert np.isfinite([lower, upper]).all()
    assert lower[1] > 0.1
    assert upper[1] < 0.3
    assert upper[0] <= np.pi
    assert (random_configurations(robot, 50, np.random.default_rng(0)) <= upper).all()


def test_spread_out_postures_come_first() -> None:
    features = np.random.default_rng(2).normal(size=(200, 3))
    order = farthest_first(features)
    assert sorted(order) == list(range(200))

    def nearest(rows: np.ndarray) -> float:
        gaps = np.linalg.norm(features[rows][:, None] - features[rows][None], axis=-1)
        return float(gaps[~np.eye(len(rows), dtype=bool)].min())

    assert nearest(order[:8]) > 3 * nearest(order[-8:])


@pytest.mark.parametrize("name", ["scorbot_er7", "panda", "z1", "jaco2"])
def test_the_camera_looks_away_from_the_arm(name: str) -> None:
    robot = _robot_or_skip(name)
    T = robot.forward(random_configurations(robot, 20, np.random.default_rng(3))[None])[0]
    frames = robot.joint_frames(random_configurations(robot, 20, np.random.default_rng(3))[None])[0]
    view = T[:, :3, :3] @ from_quaternion(np.array(facing_outward(robot)))[:, 2]
    axis = frames[:, -1, :3, :3] @ robot.axes[robot.chain[-1]]
    np.testing.assert_allclose(np.abs((view * axis).sum(axis=-1)), 1.0, atol=1e-5)


def _robot_or_skip(name: str) -> Robot:
    try:
        return find_robot(name)
    except DependencyMissing:
        pytest.skip(f"{name} is not installed")


def test_the_ball_comes_to_its_place_from_many_sides(robot: Robot) -> None:
    rng = np.random.default_rng(4)
    ball = np.array([0.03, -0.02, 0.12])
    goals = within_reach(robot, ball, 2, rng)
    q, goal = reaching(robot, ball, goals, wanted=8, rng=rng)
    np.testing.assert_allclose(apply(robot.forward(q[None])[0], ball), goals[goal], atol=1e-11)
    assert set(goal[:8]) == {0, 1}
    assert ((q > robot.lower) & (q < robot.upper)).all()
    turned = inverse(robot.forward(q[None])[0, :1]) @ robot.forward(q[None])[0]
    assert (np.trace(turned[1:8, :3, :3], axis1=1, axis2=2) < 2.9).all()


def test_a_joint_that_is_held_stays_while_the_others_reach_the_place() -> None:
    robot, rng = find_robot("ur5"), np.random.default_rng(4)
    goals = within_reach(robot, np.zeros(3), 1, rng)
    start = random_configurations(robot, 60, rng)
    held = np.arange(len(robot.joints)) == 2
    q, good = touching(robot, np.zeros(3), np.tile(goals, (60, 1)), start, still=held)
    assert good.sum() > 5
    np.testing.assert_array_equal(q[:, held], start[:, held])


def test_a_place_out_of_reach_is_said_so(robot: Robot) -> None:
    with pytest.raises(RobotError, match=r"0 configurations reach the socket at \(3.000"):
        reaching(robot, np.zeros(3), np.array([[3.0, 0.0, 0.0]]), wanted=2, rng=np.random.default_rng(1))


def test_a_pixel_on_the_margin_itself_is_within_it_whatever_the_last_bit() -> None:
    view = View(np.eye(4), {}, "u", (640, 480))
    ends = np.array([[at, 240.0] for at in view.stripe_range()])
    assert view.contains(np.nextafter(ends, -np.inf)).all()
    assert view.contains(np.nextafter(ends, np.inf)).all()
    assert not view.contains(ends + np.array([[-0.01, 0.0], [0.01, 0.0]])).any()
