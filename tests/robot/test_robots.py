"""The contract of every robot known by name: a new file is tested without an edit."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from scipy.linalg import expm
from screws import Screws

from robolaser.errors import DataError, DependencyMissing, RobotError, UsageError
from robolaser.geometry.rigid_motion import pose, rot_x, rot_z, skew
from robolaser.robot.by_name import RobotEntry, find_robot, known_robots, named
from robolaser.robot.by_name.description import rows_urdf
from robolaser.robot.kinematics import Robot

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
    assert entry.maker


def test_it_is_found_by_all_that_it_is_called(entry):
    for name in (*entry.names, entry.name.upper(), f"{entry.maker} {entry.name}", f" {entry.name} "):
        assert find_robot(name).flange == entry.flange, name


def test_it_has_the_joints_and_the_flange_it_names(entry, robot):
    assert robot.joints == entry.joints
    assert robot.flange == entry.flange
    assert robot.chain == tuple(range(len(robot.joints))), "each joint moves the flange, from base to flange"
    assert (robot.lower < robot.upper).all()
    assert robot.has_masses


def test_its_flange_and_weight_are_as_screws_say(robot, q):
    screws, few = Screws(robot.urdf, robot.joints), q[:1]
    np.testing.assert_allclose(robot.forward(few[None])[0], screws.forward(few, robot.flange), rtol=0, atol=1e-12)
    np.testing.assert_allclose(robot.gravity_torques(few), screws.torques(few), rtol=0, atol=1e-9)


def test_an_unknown_robot_is_met_with_its_likely_name(tmp_path):
    with pytest.raises(UsageError, match=r"No robot 'ur55'\. Did you mean 'ur5'\? There are: .*Or give the path"):
        find_robot("ur55")
    with pytest.raises(DataError, match="No such file"):
        find_robot(tmp_path / "robot.urdf")


def test_a_robot_of_an_absent_package_says_what_to_install():
    entry = RobotEntry(
        name="marvin", title="Marvin", maker="Sirius", aliases=(), source="", licence="", urdf="marvin.urdf",
        flange="head", joints=(), package="example-robots-nobody-has",
    )  # fmt: skip
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
        links = ET.parse(path).findall("link")
        try:
            find_robot(path, flange=links[-1].get("name") if links else "")
        except RobotError as refusal:
            refusals[path.name] = str(refusal)
    assert all(name in says for name, says in refusals.items())


CALLED = {
    "UR5e": "ur5e", "ur 5e": "ur5e", "universal robots ur5e": "ur5e", "Universal Robots UR3": "ur3",
    "lbr iiwa 14 r820": "iiwa14", "KUKA LBR iiwa 7 R800": "iiwa7", "franka research 3": "fr3",
    "Franka Emika Panda": "panda", "kinova gen3": "gen3", "irb 120": "irb120", "kr6 r900": "kr6",
    "KR 6 R900-sixx": "kr6", "xarm lite6": "lite6", "viperx 300s": "vx300s", "SCORBOT-ER VII": "scorbot_er7",
}  # fmt: skip


@pytest.mark.parametrize("typed", CALLED)
def test_a_robot_is_found_by_what_people_type(typed):
    assert named(typed).name == CALLED[typed]


def test_a_folder_of_a_robots_name_does_not_hide_the_robot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ur5e").mkdir()
    assert find_robot("ur5e").flange == "tool0"


REACH = {
    # degrees at which the arm is straight, from joint to joint (or flange), millimetres of the data sheet, and by how
    # much it may be rounded
    "iiwa7": ([0] * 7, 1, 5, 800, 0.1),
    "iiwa14": ([0] * 7, 1, 5, 820, 0.1),
    "gen3": ([0] * 7, 1, None, 902, 1),
    "fr3": ([0, 0, 0, -26.8, 0, 152.6, 0], 1, None, 855, 4),
    "irb120": ([0, 0, np.degrees(np.arctan2(70, 302)) - 90, 0, 0, 0], 1, 4, 580, 0.1),
    "kr6": ([0, 0, np.degrees(np.arctan2(35, 420)), 0, 0, 0], 1, 4, 901.5 - 25, 0.1),
    "lite6": ([0, 0, 90 + np.degrees(np.arctan2(227.6, 87)), 0, 0, 0], 1, 4, 440, 4),
}


@pytest.mark.parametrize("name", REACH)
def test_an_arm_reaches_as_far_as_its_data_sheet_says(name):
    degrees, first, last, millimetres, rounded = REACH[name]
    robot, q = find_robot(name), np.radians(degrees)[None, None]
    joints = robot.joint_frames(q)[0, 0]
    end = robot.forward(q)[0, 0] if last is None else joints[last]
    assert 1e3 * np.linalg.norm((end - joints[first])[:3, 3]) == pytest.approx(millimetres, abs=rounded)


@pytest.mark.parametrize(("name", "millimetres"), [("ur3e", 500), ("ur5e", 850), ("ur10e", 1300), ("ur16e", 900)])
def test_a_ur_reaches_beyond_its_wrist_as_far_as_its_data_sheet_says(name, millimetres):
    joints = 1e3 * find_robot(name).joint_frames(np.zeros((1, 1, 6)))[0, 0, :, :3, 3]
    upper_arm_and_forearm = np.linalg.norm((joints[3] - joints[1])[[0, 2]])
    assert upper_arm_and_forearm < millimetres < upper_arm_and_forearm + abs((joints[4] - joints[3])[2])


def test_rows_of_its_maker_give_the_ur5_of_ros():
    lengths = {"d_m": [0.089159, 0, 0, 0.10915, 0.09465, 0.0823], "a_m": [0, -0.425, -0.39225, 0, 0, 0]}
    rows = [
        {"joint": f"j{i}", "mass_kg": 1, "alpha_deg": alpha, **{key: values[i] for key, values in lengths.items()}}
        for i, alpha in enumerate([90, 0, 0, 90, -90, 0])
    ]
    ours = Robot.from_urdf(rows_urdf([{"theta_deg": 180}, *rows], "standard", "ur5", "base", "tool"), flange="tool")
    try:
        ros = find_robot("ur5")
    except DependencyMissing:
        pytest.skip("the optional package of robots is not installed")
    q = np.random.default_rng(3).uniform(-3, 3, (1, 30, 6))
    np.testing.assert_allclose(ours.forward(q), ros.forward(q), rtol=0, atol=1e-9)


def test_the_viperx_follows_the_screw_axes_of_its_maker():
    robot = find_robot("vx300s")
    axes = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]], dtype=float)
    moments = [[0, 0, 0], [-0.12705, 0, 0], [-0.42705, 0, 0.05955], [0, 0.42705, 0], [-0.42705, 0, 0.35955]]
    home = pose(np.eye(3), np.array([0.05955 + 0.3 + 0.069744 + 0.042825, 0, 0.42705]))
    for q in np.random.default_rng(7).uniform(-1.5, 1.5, (10, 6)):
        T = np.eye(4)
        for angle, w, v in zip(q, axes, [*moments, moments[3]], strict=True):
            W = np.zeros((4, 4))
            W[:3, :3], W[:3, 3] = skew(w), v
            T = T @ expm(angle * W)
        np.testing.assert_allclose(robot.forward(q[None, None])[0, 0], T @ home, rtol=0, atol=1e-12)
