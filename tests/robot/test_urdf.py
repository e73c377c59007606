"""What a URDF may be, and what every other text is told."""

import numpy as np
import pytest

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.errors import DataError, RobolaserError, RobotError
from robolaser.geometry.rigid_motion import exp_so3, pose, rot_x, rot_y, rot_z
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.editing import with_fixed_frames, with_placements

ARM = """<?xml version="1.0"?>
<!-- a two-joint arm -->
<robot name="arm">
  <link name="base"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <origin xyz="0 0 0.5" rpy="0 0.1 0"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="2"/>
  </joint>
  <link name="upper">
    <visual><geometry><mesh filename="package://gone/upper.stl"/></geometry></visual>
    <inertial><origin xyz="0.1 0 0"/><mass value="1.5"/><inertia ixx="0.1"/></inertial>
  </link>
  <joint name="rail" type="prismatic">
    <parent link="upper"/>
    <child link="tool0"/>
    <limit lower="0" upper="0.2"/>
  </joint>
  <link name="tool0"/>
</robot>
"""


def arm(text=ARM):
    return Robot.from_urdf(text, flange="tool0", source="arm.urdf")


def edited(old, new):
    assert ARM.count(old) == 1, "the test's own edit must hit once"
    return ARM.replace(old, new)


def test_a_urdf_is_read_without_its_meshes():
    robot = arm()
    assert (robot.name, robot.base, robot.links) == ("arm", "base", ("base", "upper", "tool0"))
    assert robot.joints == ("shoulder", "rail")
    assert robot.carried(np.zeros((1, 2)))[0].tolist() == [1.5, 0.0]
    assert (robot.lower.tolist(), robot.upper.tolist()) == ([-1.5, 0.0], [2.0, 0.2])
    np.testing.assert_array_equal(robot.axes, [[0, 1, 0], [1, 0, 0]])


def test_empty_lines_may_precede_the_robot():
    assert arm(f"\n \n{ARM}").joints == arm().joints
    with pytest.raises(RobotError, match=r"arm.urdf, line 15, column \d+: not well-formed"):
        arm(f"\n\n{ARM[:400]}")


def test_names_that_pinocchio_uses_itself_are_links_like_others():
    robot = Robot.from_urdf(ARM.replace('"base"', '"universe"').replace('"upper"', '"shoulder"'), flange="tool0")
    assert robot.links == ("universe", "shoulder", "tool0")
    np.testing.assert_array_equal(robot.forward(np.ones((1, 1, 2))), arm().forward(np.ones((1, 1, 2))))


WRONG = {
    "truncated": (ARM[:400], RobotError, r"arm.urdf, line 13, column \d+: not well-formed"),
    "empty": ("", RobotError, "line 1, column 1: .*no element"),
    "not XML": ("pose,q_joint_1\n1,2\n", RobotError, "line 1, column 1"),
    "lone surrogate": (edited('"tool0"/>\n    <limit', '"\ud800"/>\n    <limit'), RobotError, "surrogates"),
    "another root": ("<sdf><model/></sdf>", RobotError, "<sdf>"),
    "xacro": ('<robot xmlns:xacro="x"><xacro:arm/></robot>', RobotError, "xacro arm.urdf > robot.urdf"),
    "expression": (edited('"0 0 0.5"', '"0 0 ${h}"'), RobotError, "Expand the file with xacro"),
    "document type": (f"<!DOCTYPE robot>{ARM[21:]}", RobotError, "line 1: it declares a document type"),
    "entity bomb": ('<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>', RobotError, "refuses"),
    "foreign entity": ('<!DOCTYPE r [<!ENTITY a SYSTEM "/etc/passwd">]><robot>&a;</robot>', RobotError, "refuses"),
    "deep nesting": ("<robot>" + "<a>" * 5000 + "</a>" * 5000 + "</robot>", RobotError, "nested"),
    "huge": ("<robot>" + " " * ROBOT_BYTES + "</robot>", RobotError, "bytes"),
    "too many links": ("<robot>" + "<link/>" * 2001 + "</robot>", RobotError, "more than 2000 links"),
    "no link": ("<robot/>", RobotError, "there is no link"),
    "unnamed link": (edited('<link name="base"/>', "<link/>"), RobotError, "link number 1 has no name"),
    "endless name": (edited('"rail"', f'"{"r" * 1000}"'), RobotError, "joint number 2 has a name of 1000"),
    "two links of one name": (edited('<link name="base"/>', '<link name="upper"/>'), RobotError, "two links"),
    "two joints of one name": (edited('"rail"', '"shoulder"'), RobotError, "two joints named 'shoulder'"),
    "missing parent": (
        edited('<parent link="upper"/>', '<parent link="uper"/>'),
        RobotError,
        "'rail' has the parent link 'uper', which is not there. Did you mean 'upper'",
    ),
    "no child": (edited('<child link="tool0"/>', ""), RobotError, "'rail' has no <child"),
    "two parents": (
        edited('"tool0"/>\n    <limit', '"upper"/>\n    <limit'),
        RobotError,
        "'upper' is the child of two",
    ),
    "two roots": (edited('<link name="base"/>', '<link name="base"/><link name="b"/>'), RobotError, "2 links .*'b'"),
    "circle": (edited('<parent link="base"/>', '<parent link="tool0"/>'), RobotError, "form a loop"),
    "all in a circle": (
        edited('<parent link="base"/>', '<parent link="tool0"/>').replace('<link name="base"/>', ""),
        RobotError,
        "form a loop",
    ),
    "unknown joint type": (edited('"revolute"', '"hinge"'), RobotError, "'shoulder' is of type 'hinge'"),
    "no joint type": (edited(' type="revolute"', ""), RobotError, "'shoulder' has no type"),
    "zero axis": (edited('"0 1 0"', '"0 0 0"'), RobotError, "axis of joint 'shoulder' is '0 0 0'"),
    "infinite axis": (edited('"0 1 0"', '"0 inf 0"'), RobotError, "axis"),
    "axis of two": (edited('"0 1 0"', '"0 1"'), RobotError, "expected 3 numbers"),
    "word for a number": (edited('"0 0 0.5"', '"0 0 half"'), RobotError, "origin xyz of joint 'shoulder'"),
    "number too large": (edited('"0 0 0.5"', '"0 0 1e300"'), RobotError, "of a size that a robot has"),
    "overflowing number": (edited('upper="2"', 'upper="1e999"'), RobotError, "upper limit"),
    "endless number": (edited('upper="2"', f'upper="{"2" * 100_000}"'), RobotError, "upper limit"),
    "junk after spaces": (edited('"0 0 0.5"', f'"0 0 0.5{" " * 500}x"'), RobotError, "origin"),
    "rpy of four": (edited('"0 0.1 0"', '"0 0.1 0 0"'), RobotError, "origin rpy"),
    "no mass": (edited('<mass value="1.5"/>', ""), RobotError, "mass of link 'upper' is missing"),
    "negative mass": (edited('"1.5"', '"-1.5"'), RobotError, "zero or more"),
    "mass that is none": (edited('"1.5"', '"nan"'), RobotError, "mass"),
    "inertia that is none": (edited('ixx="0.1"', 'ixx="a"'), RobotError, "ixx of link 'upper'"),
    "no limits": (edited('<limit lower="0" upper="0.2"/>', ""), RobotError, "'rail' has no limits"),
    "limits without numbers": (edited('lower="0" upper="0.2"', 'effort="1"'), RobotError, "no limits"),
    "control character in a name": (edited('"rail"', '"ra&#9;il"'), RobotError, r"joint number 2 is named 'ra\\til'"),
    "name of Pinocchio's root": (edited('"rail"', '"universe"'), RobotError, "joint number 2 is named 'universe'"),
    "follows nothing": (
        edited('<limit lower="0"', '<mimic joint="sholder"/><limit lower="0"'),
        RobotError,
        "'rail' follows 'sholder'.* no moving joint.*Did you mean 'shoulder'",
    ),
    "follows itself": (edited('<limit lower="0"', '<mimic joint="rail"/><limit lower="0"'), RobotError, "itself"),
    "follows by a word": (
        edited('<limit lower="0"', '<mimic joint="shoulder" multiplier="x"/><limit lower="0"'),
        RobotError,
        "the multiplier of joint 'rail'",
    ),
    "swapped limits": (edited('lower="-1.5"', 'lower="3"'), RobotError, "lower limit 3 above its upper limit 2"),
}


@pytest.mark.parametrize(("text", "error", "says"), WRONG.values(), ids=WRONG.keys())
def test_what_is_wrong_is_said(text, error, says):
    with pytest.raises(error, match=says):
        arm(text)


def test_a_limit_left_out_is_zero():
    assert arm(edited('lower="0" upper="0.2"', 'upper="0.2"')).lower[1] == 0.0


def test_a_long_list_of_names_is_cut_short():
    links = "".join(f'<link name="l{i}"/>' for i in range(300))
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>' for i in range(299)
    )
    with pytest.raises(RobotError, match=r"'l1000'.*Did you mean 'l.*and 288 more\.") as caught:
        Robot.from_urdf(f"<robot>{links}{joints}</robot>", flange="l1000")
    assert len(str(caught.value)) < 300


def test_the_longest_arm_allowed_is_weighed():
    links = "".join(f'<link name="l{i}"><inertial><mass value="1"/></inertial></link>' for i in range(2000))
    joints = "".join(
        f'<joint name="j{i}" type="{"continuous" if i == 5 else "fixed"}"><parent link="l{i}"/><child link="l{i + 1}"/>'
        '<origin xyz="0 0.001 0"/></joint>'
        for i in range(1999)
    )
    robot = Robot.from_urdf(f"<robot>{links}{joints}</robot>", flange="l1999")
    assert robot.joints == ("j5",)
    bodies = 1999 - 5
    lever = 0.001 * (bodies - 1) / 2
    np.testing.assert_allclose(robot.gravity_torques(np.zeros((1, 1))), [[bodies * 9.81 * lever]], rtol=1e-9)
    np.testing.assert_allclose(robot.forward(np.zeros(1))[:3, 3], [0, 1.999, 0], rtol=0, atol=1e-12)


def test_more_joints_than_any_arm_has_are_refused():
    links = "".join(f'<link name="l{i}"/>' for i in range(300))
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
        for i in range(299)
    )
    text = f"<robot>{links}{joints}</robot>"
    with pytest.raises(RobotError, match="more than 100 moving joints"):
        Robot.from_urdf(text, flange="l299")
    assert not Robot.from_urdf(text, flange="l100").gravity_torques(np.zeros((1, 100))).any()


def test_files_are_read_with_or_without_a_byte_order_mark(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_bytes(b"\xef\xbb\xbf" + ARM.replace("\n", "\r\n").encode())
    assert find_robot(path).joints == ("shoulder", "rail")


def test_files_that_cannot_be_read_are_named(tmp_path):
    path = tmp_path / "arm.urdf"
    with pytest.raises(DataError, match=r"arm\.urdf: No such file"):
        find_robot(path)
    path.write_bytes(ARM.encode("utf-16"))
    with pytest.raises(DataError, match=r"arm\.urdf: byte 0 is not UTF-8"):
        find_robot(path)
    path.write_bytes(b" " * (ROBOT_BYTES + 1))
    with pytest.raises(DataError, match="bytes"):
        find_robot(path)


def broken(rng):
    """ARM, cut off somewhere or with a few bytes turned over."""
    data = bytearray(ARM.encode())
    if rng.random() < 0.2:
        return bytes(data[: rng.integers(len(data))])
    for at in rng.integers(len(data), size=rng.integers(1, 4)):
        data[at] = rng.integers(256) if rng.random() < 0.3 else rng.choice(list(b'0123456789.-e"/<> \n'))
    return bytes(data)


@pytest.mark.parametrize("seed", range(5))
def test_a_broken_urdf_is_refused_or_weighed(seed, tmp_path):
    rng = np.random.default_rng(seed)
    path, weighed, refusals = tmp_path / "arm.urdf", 0, []
    for _ in range(200):
        path.write_bytes(broken(rng))
        try:
            robot = Robot.from_urdf(read_text(path), flange="tool0")
            torques = robot.gravity_torques(np.zeros((1, len(robot.joints))))
            flange = robot.forward(np.zeros((1, 1, len(robot.joints))))
        except RobolaserError as refusal:
            refusals.append(str(refusal))
            continue
        weighed += 1
        assert np.isfinite(torques).all()
        assert np.isfinite(flange).all()
    assert weighed > 0
    assert 0 < max(len(says) for says in refusals) < 1000


@pytest.mark.parametrize("pitch", [0.3, -1.2, np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, 2.5])
def test_a_placement_survives_writing_and_reading_even_at_the_pole(pitch):
    rng = np.random.default_rng(3)
    for _ in range(20):
        roll, yaw = rng.uniform(-np.pi, np.pi, 2)
        T = pose(rot_z(yaw) @ rot_y(pitch) @ rot_x(roll), rng.normal(size=3))
        again = arm(with_placements(ARM, {"shoulder": T, "rail": T}))
        np.testing.assert_allclose(again.placements, [T, T], rtol=0, atol=3e-15)


def test_new_placements_leave_the_rest_of_the_file_alone():
    again = with_placements(ARM, {"shoulder": np.eye(4)})
    assert again.count("<origin") == ARM.count("<origin")
    assert "package://gone/upper.stl" in again
    assert again.count("<!-- a two-joint arm -->") == 1
    robot = arm(again)
    assert (robot.lower[0], robot.upper[0], robot.axes[0].tolist()) == (-1.5, 2.0, [0, 1, 0])


def test_a_fixed_frame_is_where_it_was_put():
    rng = np.random.default_rng(4)
    T = pose(exp_so3(rng.normal(size=3)), rng.normal(size=3))
    twice = with_fixed_frames(with_fixed_frames(ARM, "tool0", {"camera": T}), "camera", {"sheet": T})
    q = rng.normal(size=(1, 4, 2))
    flange, sheet = (Robot.from_urdf(twice, flange=frame).forward(q) for frame in ("tool0", "sheet"))
    np.testing.assert_allclose(sheet, flange @ T @ T, rtol=0, atol=1e-14)


def test_a_fixed_frame_needs_a_parent_and_gets_a_name_of_its_own():
    with pytest.raises(RobotError, match="Did you mean 'tool0'"):
        with_fixed_frames(ARM, "tool", {"camera": np.eye(4)})
    assert "upper_2" in arm(with_fixed_frames(ARM, "tool0", {"upper": np.eye(4)})).links
    with pytest.raises(RobotError, match="'elbow'"):
        with_placements(ARM, {"elbow": np.eye(4)})
    taken = with_fixed_frames(edited('"rail"', '"camera_joint"'), "tool0", {"camera": np.eye(4)})
    assert '"camera_joint_2"' in taken
    assert "camera" in arm(taken).links


def test_what_others_wrote_into_a_urdf_survives_edits():
    gazebo = '<gazebo><sensor:camera xmlns:sensor="s" name="eye"/></gazebo><!-- kept --></robot>'
    again = with_fixed_frames(ARM.replace("</robot>", gazebo), "tool0", {"camera": np.eye(4)})
    assert '<sensor:camera xmlns:sensor="s" name="eye"' in again
    assert "<!-- kept -->" in again
