"""What a robot's kinematics and weight must agree with."""

import numpy as np
import pytest
from screws import Screws, origin

from robolaser.errors import RobotError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose
from robolaser.robot.kinematics import Robot

# A lift, a turntable without end, a wrist about a slanting axis, a finger beside the flange, a massive dead weight.
MIXED = """
<robot name="mixed">
  <link name="floor"/>
  <joint name="lift" type="prismatic">
    <parent link="floor"/><child link="carriage"/>
    <origin xyz="0.1 0 0.2" rpy="0.3 -0.2 0.1"/><axis xyz="0 0.6 0.8"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/>
  </joint>
  <link name="carriage">
    <inertial><origin xyz="0 0.1 0"/><mass value="3"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <joint name="bracket" type="fixed">
    <parent link="carriage"/><child link="plate"/><origin xyz="0 0.2 0.1" rpy="0 1.5707963267948966 0.4"/>
  </joint>
  <link name="plate"/>
  <joint name="table" type="continuous">
    <parent link="plate"/><child link="arm"/><origin xyz="0.4 0 0" rpy="1 2 3"/><axis xyz="0 -1 0"/>
  </joint>
  <link name="arm">
    <inertial><origin xyz="0.2 0 0.05"/><mass value="2"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
  </link>
  <joint name="wrist" type="revolute">
    <parent link="arm"/><child link="hand"/><origin xyz="0.3 0 0"/><axis xyz="3 -2 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
  </joint>
  <link name="hand">
    <inertial><mass value="1"/><inertia ixx="1" ixy="9" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <joint name="mount" type="fixed">
    <parent link="hand"/><child link="flange"/><origin xyz="0 0 0.1" rpy="0 0 1"/>
  </joint>
  <link name="flange"/>
  <joint name="finger" type="revolute">
    <parent link="hand"/><child link="fingertip"/><origin xyz="0 0.1 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="fingertip">
    <inertial><origin xyz="0 0 0.2"/><mass value="0.4"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <joint name="thumb" type="revolute">
    <parent link="hand"/><child link="thumbtip"/><axis xyz="1 0 0"/><mimic joint="finger"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="thumbtip">
    <inertial><origin xyz="0 0 0.1"/><mass value="0.3"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
</robot>
"""
CHAIN = ("lift", "table", "wrist")


def screws_say(joints, q, flange="flange", moved=None, gravity=(0.0, 0.0, -9.81), text=MIXED):
    """Flange poses (n, 4, 4) and gravity torques (n, j) by products of exponentials; `moved` replaces placements."""
    arm = Screws(text, joints, moved)
    return arm.forward(q, flange), arm.torques(q, gravity)


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def robot():
    return Robot.from_urdf(MIXED, flange="flange")


def turned_a_little(robot, rng, c, n):
    """Placements (c, n, j, 4, 4) that depart from nominal as links do."""
    j = len(robot.joints)
    slight = pose(exp_so3(0.1 * rng.normal(size=(c, n, j, 3))), 0.01 * rng.normal(size=(c, n, j, 3)))
    return robot.placements @ slight


def test_the_flange_is_where_screws_say(robot, rng):
    q = rng.uniform(-3, 3, (20, 3))
    assert robot.joints == CHAIN
    assert robot.chain == (0, 1, 2)
    poses, _ = screws_say(CHAIN, q)
    np.testing.assert_allclose(robot.forward(q[None])[0], poses, rtol=0, atol=1e-12)


def test_joints_bear_the_weight_that_screws_say(robot, rng):
    q = rng.uniform(-3, 3, (20, 3))
    _, torques = screws_say(CHAIN, q)
    np.testing.assert_allclose(robot.gravity_torques(q), torques, rtol=0, atol=1e-12)
    assert robot.has_masses


@pytest.mark.parametrize("gravity", [(0, 0), "down", (0, 0, np.nan), 9.81, None])
def test_a_gravity_that_is_not_three_numbers_is_refused(gravity):
    with pytest.raises(UsageError, match="expected three numbers"):
        Robot.from_urdf(MIXED, flange="flange", gravity=gravity)


def test_on_a_wall_gravity_pulls_sideways(rng):
    sideways = (9.81, 0.0, 0.0)
    robot = Robot.from_urdf(MIXED, flange="flange", gravity=sideways)
    q = rng.uniform(-3, 3, (5, 3))
    _, torques = screws_say(CHAIN, q, gravity=sideways)
    np.testing.assert_allclose(robot.gravity_torques(q), torques, rtol=0, atol=1e-12)


def test_columns_follow_the_listed_order_and_joints_beside_the_chain_do_not_move_the_flange(rng):
    listed = ("finger", "wrist", "lift", "table")
    robot = Robot.from_urdf(MIXED, flange="flange", joints=listed)
    q = rng.uniform(-2, 2, (10, 4))
    poses, torques = screws_say(listed, q)
    assert robot.chain == (2, 3, 1)
    np.testing.assert_allclose(robot.forward(q[None])[0], poses, rtol=0, atol=1e-12)
    np.testing.assert_allclose(robot.gravity_torques(q), torques, rtol=0, atol=1e-12)


def test_unlisted_joints_stay_at_neutral(rng):
    robot = Robot.from_urdf(MIXED, flange="flange", joints=["wrist", "lift"])
    q = rng.uniform(-2, 2, (10, 2))
    poses, torques = screws_say(("wrist", "lift"), q)
    np.testing.assert_allclose(robot.forward(q[None])[0], poses, rtol=0, atol=1e-12)
    np.testing.assert_allclose(robot.gravity_torques(q), torques, rtol=0, atol=1e-12)


def test_moved_joints_carry_the_flange_as_moved_screws_do(robot, rng):
    q = rng.uniform(-2, 2, (6, 3))
    moved = turned_a_little(robot, rng, 4, 1)
    found = robot.forward(q[None], moved)
    bracket = inverse(robot.placements[1]) @ moved[:, 0, 1]
    own = origin(Screws(MIXED, CHAIN).above["arm"])
    for c in range(4):
        names = {"lift": moved[c, 0, 0], "table": own @ bracket[c], "wrist": moved[c, 0, 2]}
        poses, _ = screws_say(CHAIN, q, moved=names)
        np.testing.assert_allclose(found[c], poses, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shape", [(1, 1), (3, 1), (1, 5), (3, 5)])
@pytest.mark.parametrize("candidates", [1, 3])
def test_a_candidate_moves_as_it_does_alone(robot, rng, shape, candidates):
    q = rng.uniform(-2, 2, (candidates, 5, 3))
    moved = turned_a_little(robot, rng, *shape)
    together = robot.forward(q, moved)
    assert together.shape == (max(candidates, shape[0]), 5, 4, 4)
    for c in range(together.shape[0]):
        for n in range(5):
            alone = robot.forward(q[c % candidates, n][None, None], moved[c % shape[0], n % shape[1]][None, None])
            np.testing.assert_allclose(together[c, n], alone[0, 0], rtol=0, atol=1e-14)


def test_nominal_placements_change_nothing(robot, rng):
    q = rng.uniform(-2, 2, (2, 5, 3))
    assert np.array_equal(robot.forward(q), robot.forward(q, robot.placements[None, None]))


def test_forward_leaves_its_arguments_alone(robot, rng):
    q, moved = rng.uniform(-2, 2, (2, 5, 3)), turned_a_little(robot, rng, 2, 1)
    before = q.copy(), moved.copy()
    robot.forward(q, moved)
    assert np.array_equal(q, before[0])
    assert np.array_equal(moved, before[1])


def test_the_last_joint_carries_the_flange_and_each_joint_turns_only_what_comes_after(robot, rng):
    q, moved = rng.uniform(-2, 2, (3, 5, 3)), turned_a_little(robot, rng, 1, 1)
    frames = robot.joint_frames(q, moved)
    np.testing.assert_allclose(frames[:, :, -1] @ robot.end, robot.forward(q, moved), rtol=0, atol=1e-14)
    turned = robot.joint_frames(q + np.array([0.0, 0.3, 0.0]), moved)
    np.testing.assert_allclose(turned[:, :, 0], frames[:, :, 0], rtol=0, atol=1e-14)
    own = exp_so3(0.3 * robot.axes[1])
    np.testing.assert_allclose(turned[:, :, 1, :3, :3], frames[:, :, 1, :3, :3] @ own, rtol=0, atol=1e-14)
    np.testing.assert_allclose(turned[:, :, 1, :3, 3], frames[:, :, 1, :3, 3], rtol=0, atol=1e-14)


def test_a_continuous_joint_has_no_limits_and_the_others_have_theirs(robot):
    assert robot.lower.tolist() == [0.0, -np.inf, -2.0]
    assert robot.upper.tolist() == [0.5, np.inf, 2.0]
    assert robot.prismatic.tolist() == [True, False, False]
    np.testing.assert_allclose(np.linalg.norm(robot.axes, axis=1), 1.0, atol=1e-15)


def test_an_arm_without_masses_bears_nothing_and_carries_none_at_its_joints():
    weightless = MIXED.replace("<mass", "<mass_unknown").replace("<inertial>", "<other>")
    robot = Robot.from_urdf(weightless.replace("</inertial>", "</other>"), flange="flange")
    assert not robot.has_masses
    q = np.ones((2, 3))
    assert not robot.gravity_torques(q).any()
    masses, centres = robot.carried(q)
    assert not masses.any()
    np.testing.assert_allclose(centres, robot.joint_frames(q[None])[0, ..., :3, 3], rtol=0, atol=1e-15)


def test_what_a_joint_carries_is_the_masses_beyond_it_and_their_centre(robot, rng):
    q, screws = rng.uniform(-2, 2, (4, 3)), Screws(MIXED, CHAIN)
    masses, centres = robot.carried(q)
    beyond = {"lift": ("carriage", "arm", "hand", "fingertip", "thumbtip"), "wrist": ("hand", "fingertip", "thumbtip")}
    for joint, links in beyond.items():
        bodies = {name: screws.links[name].find("inertial") for name in links}
        weights = np.array([float(body.find("mass").get("value")) for body in bodies.values()])
        for row, found in zip(q, centres[:, CHAIN.index(joint)], strict=True):
            at = [(screws.link(name, row) @ origin(body))[:3, 3] for name, body in bodies.items()]
            np.testing.assert_allclose(found, weights @ at / weights.sum(), rtol=0, atol=1e-13)
        np.testing.assert_allclose(masses[CHAIN.index(joint)], weights.sum(), rtol=1e-14)


def test_wrong_names_are_met_with_the_right_ones():
    with pytest.raises(RobotError, match=r"No frame 'flang' in ur5.urdf. Did you mean 'flange'\? .*carriage"):
        Robot.from_urdf(MIXED, flange="flang", source="ur5.urdf")
    with pytest.raises(RobotError, match=r"No moving joint 'wirst' .*Did you mean 'wrist'"):
        Robot.from_urdf(MIXED, flange="flange", joints=["wirst"])
    with pytest.raises(RobotError, match="No moving joint 'mount'"):
        Robot.from_urdf(MIXED, flange="flange", joints=["mount"])
    with pytest.raises(RobotError, match=r"'wrist' .* twice"):
        Robot.from_urdf(MIXED, flange="flange", joints=["wrist", "wrist"])
    with pytest.raises(RobotError, match=r"moves the flange 'flange'\. Joints that do: lift, table, wrist"):
        Robot.from_urdf(MIXED, flange="flange", joints=["finger"])
    with pytest.raises(RobotError, match="Joints that do: none"):
        Robot.from_urdf(MIXED, flange="floor")


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_a_floating_flange_is_refused_and_a_floating_thumb_is_not(kind):
    def loosened(joint):
        return MIXED.replace(f'name="{joint}" type="revolute"', f'name="{joint}" type="{kind}"')

    with pytest.raises(RobotError, match=f"'wrist' is of type '{kind}'; usable here: revolute"):
        Robot.from_urdf(loosened("wrist"), flange="flange")
    assert Robot.from_urdf(loosened("thumb"), flange="flange").gravity_torques(np.zeros((1, 3))).shape == (1, 3)
