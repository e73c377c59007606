"""A robot may be described by a URDF, xacro, MJCF or a table of Denavit-Hartenberg numbers: all are the same arm."""

from pathlib import Path

import numpy as np
import pytest

from robolaser import find_robot
from robolaser.data.importers.robots import DescriptionOptions
from robolaser.errors import DataError, RobotError, UsageError
from robolaser.robot.kinematics import Robot

URDF = """<robot name="arm">
  <link name="base"><visual><geometry><mesh filename="package://arm_description/meshes/nowhere.stl"/></geometry></visual></link>
  <link name="upper"><inertial><origin xyz="0 0 0.1"/><mass value="2.0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.1 0 0"/><mass value="1.0"/></inertial></link>
  <link name="plate"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.4" rpy="0 0 0.2"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
    <origin xyz="0 0 0.3"/><axis xyz="1 0 0"/><limit lower="-1" upper="2"/></joint>
  <joint name="end" type="fixed"><parent link="fore"/><child link="plate"/><origin xyz="0 0 0.2"/></joint>
</robot>
"""
XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="height" default=""/>
  <xacro:include filename="$(find arm_description)/urdf/links.xacro"/>
  <xacro:property name="height" value="$(arg height)"/>
  <xacro:arm z="${height * 2}"/>
</robot>
"""
BARE = XACRO.replace('<xacro:arg name="height" default=""/>', "")
BODY = URDF[URDF.index("<link") : URDF.index("</robot>")].replace('"0 0 0.4"', '"0 0 ${z}"')
MACRO = f"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:macro name="arm" params="z">{BODY}</xacro:macro></robot>
"""
MJCF = """<mujoco model="arm">
  <compiler angle="degree"/>
  <asset><mesh name="shape" file="nowhere.stl"/><texture name="t" type="2d" file="nowhere.png"/>
    <material name="paint" texture="t"/></asset>
  <worldbody>
    <body name="upper" pos="0 0 0.4" euler="0 0 11.459155902616465">
      <inertial pos="0 0 0.1" mass="2.0" diaginertia="0.01 0.01 0.01"/>
      <joint name="shoulder" axis="0 1 0" range="-114.59155902616465 114.59155902616465"/>
      <geom type="mesh" mesh="shape" material="paint"/>
      <body name="fore" pos="0 0 0.3">
        <inertial pos="0.1 0 0" mass="1.0" diaginertia="0.01 0.01 0.01"/>
        <joint name="elbow" axis="1 0 0" range="-57.29577951308232 114.59155902616465"/>
        <geom type="box" size="0.1 0.1 0.1" material="paint"/>
        <site name="plate" pos="0 0 0.2"/>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="elbow"/></actuator>
</mujoco>
"""


@pytest.fixture
def arm(tmp_path: Path) -> Robot:
    (tmp_path / "arm.urdf").write_text(URDF, "utf-8")
    return find_robot(tmp_path / "arm.urdf")


def assert_same(robot: Robot, arm: Robot) -> None:
    q = np.random.default_rng(2).uniform(-1, 1, (20, 2))
    assert robot.joints == arm.joints
    np.testing.assert_allclose(robot.forward(q[None]), arm.forward(q[None]), rtol=0, atol=1e-9)
    np.testing.assert_allclose(robot.gravity_torques(q), arm.gravity_torques(q), rtol=0, atol=1e-9)
    np.testing.assert_allclose([robot.lower, robot.upper], [arm.lower, arm.upper], atol=1e-9)


def test_a_xacro_file_finds_its_package_without_ros(arm, tmp_path):
    pytest.importorskip("xacro")
    folder = tmp_path / "arm_description" / "urdf"
    folder.mkdir(parents=True)
    (folder / "arm.urdf.xacro").write_text(XACRO, "utf-8")
    (folder / "links.xacro").write_text(MACRO, "utf-8")
    said = DescriptionOptions(xacro={"height": "0.2"})
    assert_same(find_robot(folder / "arm.urdf.xacro", options=said), arm)


def test_what_a_xacro_file_lacks_is_asked_for(tmp_path):
    pytest.importorskip("xacro")
    (tmp_path / "arm.xacro").write_text(BARE, "utf-8")
    with pytest.raises(RobotError, match=r"the package arm_description is missing\. Put its folder next to"):
        find_robot(tmp_path / "arm.xacro")
    (tmp_path / "arm.xacro").write_text(BARE.replace("$(find arm_description)/urdf/", ""))
    (tmp_path / "links.xacro").write_text(MACRO, "utf-8")
    with pytest.raises(UsageError, match=r"asks for the argument height\. State it with --xacro-arg height=VALUE"):
        find_robot(tmp_path / "arm.xacro")
    (tmp_path / "arm.xacro").write_text(XACRO.replace("height * 2", "[].__class__"), "utf-8")
    with pytest.raises(RobotError, match=r"arm\.xacro"):
        find_robot(tmp_path / "arm.xacro")


def test_an_mjcf_file_needs_no_meshes(arm, tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(MJCF, "utf-8")
    assert_same(find_robot(tmp_path / "arm.xml"), arm)


def test_an_mjcf_arm_moves_as_mujoco_says(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    odd = """<mujoco><worldbody><body name="a" pos="0 0.1 1" euler="10 20 30">
      <joint name="turn" axis="0 0.6 0.8" pos="0.1 -0.2 0.05" ref="25"/>
      <joint name="slide" type="slide" axis="1 0 0" ref="0.3" range="-1 1"/>
      <geom type="sphere" size="0.1" pos="0.05 0 0"/>
      <body name="b" pos="0.3 0 0.1" euler="-40 5 0"><joint name="roll" axis="0 0 1" pos="0 0.1 0"/>
      <geom type="capsule" size="0.02 0.1"/></body></body></worldbody></mujoco>"""
    (tmp_path / "odd.xml").write_text(odd, "utf-8")
    robot = find_robot(tmp_path / "odd.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "odd.xml"))
    data = mujoco.MjData(model)
    for q in np.random.default_rng(3).uniform(-1, 1, (20, 3)):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        T = robot.forward(q[None, None])[0, 0]
        np.testing.assert_allclose(T[:3, 3], data.body("b").xpos, atol=1e-12)
        np.testing.assert_allclose(T[:3, :3].ravel(), data.body("b").xmat, atol=1e-12)
        np.testing.assert_allclose(robot.gravity_torques(q[None])[0], data.qfrc_bias, atol=1e-9)


@pytest.mark.parametrize(
    "text", ["<mujoco", "<mujoco><worldbody><body/></mujoco>", "<mujoco><include file='/x'/></mujoco>"]
)
def test_a_damaged_mjcf_file_ends_with_its_name(text, tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(text, "utf-8")
    with pytest.raises(RobotError, match=r"arm\.xml: MuJoCo does not read it"):
        find_robot(tmp_path / "arm.xml")


CSV = """name,a_mm,alpha,d_mm,theta,lower,upper
one,0,90,300,0,-170,170
two,250,0,0,90,,
"""
DEG = DescriptionOptions("standard", ("deg",))
TOML = """convention = "standard"
units = ["mm", "deg"]
[[joint]]
name = "one"
a = 0
alpha = 90
d = 300
theta = 0
lower = -170
upper = 170
[[joint]]
name = "two"
a = 250
alpha = 0
d = 0
theta_rad = 1.5707963267948966
"""


def test_a_table_of_dh_numbers_is_the_same_arm_as_csv_and_toml(tmp_path):
    (tmp_path / "arm.csv").write_text(CSV, "utf-8")
    (tmp_path / "arm.toml").write_text(TOML, "utf-8")
    table = find_robot(tmp_path / "arm.csv", options=DEG)
    assert table.urdf == find_robot(tmp_path / "arm.toml").urdf
    assert table.joints == ("one", "two")
    np.testing.assert_allclose(table.forward(np.zeros((1, 1, 2)))[0, 0, :3, 3], [0, 0, 0.55], atol=1e-12)
    np.testing.assert_allclose(table.upper, [np.deg2rad(170), np.inf])


@pytest.mark.parametrize(
    ("text", "said", "expected"),
    [
        (CSV, DescriptionOptions(None, ("deg",)), "State `convention` in a TOML file, or --dh of `robolaser import`"),
        (CSV, DescriptionOptions("standard"), "row 1: in which unit is alpha"),
        (CSV, DescriptionOptions("standard", ("degrees",)), "no unit 'degrees'. Did you mean 'deg'"),
        (CSV.replace("theta", "thetta"), DEG, "no such column: thetta"),
        (CSV.replace(",90,,", ",q2 - 90,,"), DEG, "row 2, column theta: 'q2 - 90'"),
        (CSV.replace("250", "1e300"), DEG, "row 2, column a_mm"),
        (CSV.replace("250", "nan"), DEG, "row 2, column a_mm: 'nan', expected a number"),
        (CSV.replace(",theta", "").replace(",0,-170", ",-170"), DEG, "row [23]: [67] cells"),
        ("", DescriptionOptions("standard"), "arm.csv is empty"),
    ],
)
def test_what_a_table_leaves_open_is_asked_for_and_what_is_wrong_is_named(text, said, expected, tmp_path):
    (tmp_path / "arm.csv").write_text(text, "utf-8")
    with pytest.raises((DataError, RobotError, UsageError), match=expected):
        find_robot(tmp_path / "arm.csv", options=said)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("joint = 3", r"joint: 3, expected sections \[\[joint\]\]"),
        ("[[joint]]\na = ", "not valid TOML"),
        (TOML.replace("standard", "craig"), 'convention: \'craig\', expected "modified" or "standard"'),
        (TOML.replace("units", "unit"), r"unit: this key is not known\. Did you mean 'units'"),
        (TOML.replace("a = 250", "a = true"), "row 2, column a"),
        (TOML.replace("d = 0\n", ""), "row 2 lacks d"),
    ],
)
def test_a_wrong_toml_table_is_named(text, expected, tmp_path):
    (tmp_path / "arm.toml").write_text(text, "utf-8")
    with pytest.raises((DataError, RobotError), match=expected):
        find_robot(tmp_path / "arm.toml")


@pytest.mark.parametrize("suffix", [".csv", ".toml", ".xml", ".xacro", ".urdf"])
def test_a_file_that_is_not_there_or_no_text_is_named(suffix, tmp_path):
    with pytest.raises((DataError, RobotError), match=f"gone{suffix}"):
        find_robot(tmp_path / f"gone{suffix}")
    (tmp_path / f"bad{suffix}").write_bytes(b"\xff\xfe\x00" * 30)
    with pytest.raises((DataError, RobotError), match=f"bad{suffix}"):
        find_robot(tmp_path / f"bad{suffix}")
