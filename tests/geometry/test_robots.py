"""The contract of every robot known by name: a new file is tested without an edit."""

import numpy as np
import pytest

from robolaser.errors import DataError, DependencyMissing, RobotError, UsageError
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import pose, rot_x, rot_z
from robolaser.geometry.robots import RobotEntry, find_robot, known_robots

FORK = """
<robot name="fork">
  <link name="base"/><link name="tine_1"/><link name="tine_2"/>
  <joint name="swing_1" type="continuous"><parent link="base"/><child link="tine_1"/></joint>
  <joint name="swing_2" type="continuous"><parent link="base"/><child link="tine_2"/></joint>
</robot>
"""


@pytest.fixture(params=known_robots(), ids=lambda entry: entry.name)
def entry(request):
    try:
        request.param.path()
    except DependencyMissing:
        pytest.skip("the optional package of robots is not installed")
    return request.param


@pytest.fixture
def robot(entry):
    return find_robot(entry.name)


@pytest.fixture
def q(robot):
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return np.random.default_rng(11).uniform(lower, upper, (20, len(robot.joints)))


def test_it_names_where_it_comes_from(entry):
    assert entry.title
    assert len(entry.source) > 10
    assert entry.licence


def test_it_has_the_joints_and_the_flange_it_names(entry, robot):
    assert robot.joints == entry.joints
    assert robot.flange == entry.flange
    assert robot.chain == tuple(range(len(robot.joints))), "each joint moves the flange, from base to flange"
    assert (robot.lower < robot.upper).all()


def test_its_flange_and_weight_are_as_pinocchio_says(robot, q):
    pinocchio = pytest.importorskip("pinocchio")
    model = pinocchio.buildModelFromXML(robot.urdf)
    data = model.createData()
    joints = [model.joints[model.getJointId(name)] for name in robot.joints]
    poses, torques = [], []
    for row in q:
        full = pinocchio.neutral(model)
        for joint, value in zip(joints, row, strict=True):
            full[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else [np.cos(value), np.sin(value)]
        pinocchio.framesForwardKinematics(model, data, full)
        poses.append(data.oMf[model.getFrameId(robot.flange, pinocchio.BODY)].homogeneous.copy())
        torques.append(pinocchio.computeGeneralizedGravity(model, data, full)[[joint.idx_v for joint in joints]])
    np.testing.assert_allclose(robot.forward(q[None])[0], poses, rtol=0, atol=1e-12)
    np.testing.assert_allclose(robot.gravity_torques(q), torques, rtol=0, atol=1e-9)


def test_its_arm_weighs_something(robot):
    assert robot.has_masses


def test_an_unknown_robot_is_met_with_its_likely_name(tmp_path):
    with pytest.raises(UsageError, match=r"No robot 'ur55'\. Did you mean 'ur5'"):
        find_robot("ur55")
    with pytest.raises(DataError, match="No such file"):
        find_robot(tmp_path / "robot.urdf")


def test_a_robot_of_an_absent_package_says_what_to_install():
    entry = RobotEntry(
        name="marvin",
        title="Marvin",
        source="",
        licence="",
        urdf="marvin.urdf",
        flange="head",
        joints=(),
        package="example-robots-nobody-has",
    )
    with pytest.raises(DependencyMissing, match=r"pip install --upgrade 'robolaser\[robots\]'"):
        entry.path()


def test_a_urdf_with_one_end_needs_no_flange_and_one_with_two_does(tmp_path):
    path = tmp_path / "fork.urdf"
    path.write_text(FORK, encoding="utf-8")
    with pytest.raises(RobotError, match="2 ends: tine_1, tine_2"):
        find_robot(path)
    assert find_robot(str(path), flange="tine_2").joints == ("swing_2",)
    assert find_robot(path, flange="tine_2", joints=["swing_1", "swing_2"]).chain == (1,)
    scorbot = next(entry for entry in known_robots() if entry.name == "scorbot_er7")
    assert find_robot(scorbot.path()).flange == "flange"


def test_the_scorbot_follows_its_denavit_hartenberg_rows():
    rows = [(-90, 0.05, 0.3585), (0, 0.3, -0.035), (0, 0.25, 0), (-90, 0, 0), (0, 0, 0.251)]
    robot = find_robot("scorbot_er7")
    q = np.random.default_rng(5).uniform(robot.lower, robot.upper, (1, 30, 5))
    T = np.eye(4)
    for i, (alpha, a, d) in enumerate(rows):
        turn = pose(rot_z(q[..., i]), np.array([0.0, 0.0, d]))
        T = T @ turn @ pose(rot_x(np.radians(alpha)), np.array([a, 0.0, 0.0]))
    np.testing.assert_allclose(robot.forward(q), T, rtol=0, atol=1e-12)


def test_the_scorbot_has_the_ranges_and_the_reach_of_its_maker():
    robot = find_robot("scorbot_er7")
    np.testing.assert_allclose(np.degrees(robot.upper - robot.lower), [250, 170, 225, 180, 360])
    stretched = robot.forward(np.array([[[0, 0, 0, -np.pi / 2, 0]]]))[0, 0]
    assert np.hypot(stretched[0, 3], 0) == pytest.approx(0.851, abs=1e-3)


def test_every_urdf_of_the_optional_package_is_read_or_refused_politely():
    entry = next(entry for entry in known_robots() if entry.name == "ur5")
    try:
        folder = entry.path().parents[2]
    except DependencyMissing:
        pytest.skip("the optional package of robots is not installed")
    refusals = {}
    for path in sorted(folder.rglob("*_description/*/*.urdf")):
        try:
            urdf.parse(urdf.load_text(path), source=path.name)
        except RobotError as refusal:
            refusals[path.name] = str(refusal)
    assert all(name in says for name, says in refusals.items())
