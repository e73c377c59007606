"""The placements of a calibrated arm in the user's own MJCF."""

import re
from pathlib import Path

import numpy as np
import pytest

import robolaser
from robolaser.cli import main
from robolaser.errors import RobotError
from robolaser.export.into import Written
from robolaser.export.into_mjcf import placements_into_mjcf
from robolaser.geometry.rigid_motion import exp_so3, inverse, log_so3, pose, rot_z
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

mujoco = pytest.importorskip("mujoco")

URDF = """<robot name="arm"><link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="turn" type="continuous"><parent link="base"/><child link="a"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
</joint>
<joint name="elbow" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.1 0 0.3"/><axis xyz="0 1 0"/>
</joint>
<joint name="extend" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0.3 0 0"/><axis xyz="1 0 0"/>
  <limit lower="-0.2" upper="0.2" effort="0" velocity="0"/></joint>
<joint name="roll" type="continuous"><parent link="c"/><child link="d"/><origin xyz="0.1 0 0.05" rpy="0 0.5 0"/>
  <axis xyz="1 0 0"/></joint>
</robot>
"""
MJCF = """<mujoco model='mine'> <!-- mine -->
  <compiler angle="degree" fusestatic="true"/>
  <default><default class="turning"><joint axis="0 0 1" damping="2"/></default></default>
  <asset><mesh name="shape" file="nowhere.stl"/></asset>
  <worldbody>
    <body name="pedestal" pos="1 2 0.1" euler="0 0 90" childclass="turning">
      <geom size="0.1"/>
      <body name="a"  pos="0 0 0.3" ><joint name="turn"/><geom type="mesh" mesh="shape"/>
        <body name="b" pos="0.12 0 0.3"   axisangle="1 0 0 -90"><geom size="0.1"/>
          <body pos="0.05 0 0"><geom size="0.1"/>
            <body name="c" pos="0.2 0 0"><joint name="extend" type="slide" axis="1 0 0"/><geom size="0.1"/>
              <body name="d" pos="0.13 -0.05 0" euler="0 0 28.64788975654116">
                <joint name="roll" axis="1 0 0"/><geom size="0.1"/>
                <body name="gripper" pos="0.1 0 0" euler="10 20 30"><joint name="finger" ref="10"/><geom size="0.1"/>
                  <body name="tip" pos="0 0.1 0"/></body>
              </body>
            </body>
          </body>
          <joint name="elbow" pos="-0.02 0 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="elbow" kp="50"/></actuator>
</mujoco>
"""
BASE = pose(rot_z(np.array(np.pi / 2)), np.array([1.0, 2.0, 0.0]))
Q = np.random.default_rng(1).uniform([-3, -3, -0.2, -3], [3, 3, 0.2, 3], (20, 4))
ZERO = np.zeros((1, 4))
NAMES = ("turn", "elbow", "extend", "roll")


@pytest.fixture(scope="module")
def nominal() -> Robot:
    return Robot.from_urdf(URDF, flange="d")


@pytest.fixture(scope="module")
def corrected(nominal: Robot) -> Robot:
    rng = np.random.default_rng(2)
    motions = pose(exp_so3(rng.normal(0, 0.01, (4, 3))), rng.normal(0, 0.003, (4, 3)))
    return nominal.with_placements(nominal.placements @ motions, rng.normal(0, 0.02, 4))


def written(folder: Path, text: str, nominal: Robot, corrected: Robot) -> Written:
    (folder / "mine.xml").write_text(text, "utf-8")
    found = [{"effect": "joint_offset", "where": "roll"}, {"effect": "link_geometry", "where": "turn"},
             {"effect": "joint_compliance", "where": "elbow"}]  # fmt: skip
    return placements_into_mjcf(folder / "mine.xml", text, nominal, corrected, found)


def tips(text: str, q: np.ndarray, names: tuple[str, ...] = NAMES) -> np.ndarray:
    """T_world_tip by MuJoCo, (n, 4, 4)."""
    text = re.sub("<asset>.*</asset>", "", text).replace('type="mesh" mesh="shape"', 'size="0.1"')
    model = mujoco.MjModel.from_xml_string(text.replace(' fusestatic="true"', ""))
    state, found = mujoco.MjData(model), []
    for row in q:
        state.qpos[[model.joint(name).qposadr[0] for name in names]] = row
        mujoco.mj_kinematics(model, state)
        found.append(pose(state.body("tip").xmat.reshape(3, 3), state.body("tip").xpos))
    return np.array(found)


def test_all_that_the_copy_carries_moves_as_on_the_calibrated_arm(tmp_path, nominal, corrected):
    copy = written(tmp_path, MJCF, nominal, corrected)
    on_flange = inverse(BASE @ nominal.forward(ZERO)) @ tips(MJCF, ZERO)
    np.testing.assert_allclose(tips(MJCF, Q), BASE @ nominal.forward(Q) @ on_flange, atol=1e-9)
    np.testing.assert_allclose(tips(copy.text, Q), BASE @ corrected.forward(Q) @ on_flange, atol=1e-9)
    assert copy.contains == (("joint_offset", "roll"), ("link_geometry", "turn"))
    assert copy.lacks == (("joint_compliance", "elbow"),)
    assert copy.remarks == ()


def screws(T: np.ndarray) -> np.ndarray:
    """Angles of motions and shifts along their axes, whatever the frame, (n, 2)."""
    moved = T[1:] @ inverse(T[0])
    turn = log_so3(moved[:, :3, :3])
    angle = np.linalg.norm(turn, axis=1)
    return np.stack([angle, (turn * moved[:, :3, 3]).sum(axis=1) / angle], axis=1)


@pytest.mark.parametrize(
    ("was", "now"),
    [
        ('pos="0.13 -0.05 0" euler="0 0 28.64788975654116"', 'pos="0.1304 -0.0498 0" quat="0.969 0 0 0.247"'),
        ('<joint name="turn"/>', '<joint name="turn" ref="25"/>'),
        ('"c" pos="0.2 0 0"><joint name="extend"', '"c" pos="0.3 0 0"><joint name="extend" ref="0.1"'),
        ('<body name="a"', '<joint type="free"/><body name="a"'),
    ],
)
def test_rounded_lengths_and_other_references_do_not_matter(was, now, tmp_path, nominal, corrected):
    changed = MJCF.replace(was, now)
    assert changed != MJCF
    copy = written(tmp_path, changed, nominal, corrected)
    np.testing.assert_allclose(screws(tips(copy.text, Q)), screws(corrected.forward(Q)), atol=1e-9)


def test_joints_of_other_names_are_matched_by_their_axes(tmp_path, nominal, corrected):
    other = MJCF
    for number, name in enumerate(NAMES):
        other = other.replace(f'"{name}"', f'"j{number}"')
    copy = written(tmp_path, other, nominal, corrected)
    np.testing.assert_allclose(
        tips(copy.text, Q, ("j0", "j1", "j2", "j3")),
        tips(written(tmp_path, MJCF, nominal, corrected).text, Q),
        atol=1e-12,
    )
    assert "j0 is turn, j1 is elbow, j2 is extend, j3 is roll" in copy.remarks[0]


def test_only_the_placements_of_moved_bodies_are_changed(tmp_path, nominal):
    corrected = nominal.with_placements(nominal.placements, np.array([0.0, 0.0, 0.0, 0.1]))
    text = written(tmp_path, MJCF, nominal, corrected).text
    before, after = MJCF.splitlines(), text.splitlines()
    (line,) = [number for number, (was, now) in enumerate(zip(before, after, strict=True)) if was != now]
    assert re.fullmatch(r' +<body name="d" pos="[^"]*" quat="[^"]*">', after[line])


def inserted(before: str, element: str) -> str:
    return MJCF.replace(before, element + before)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (MJCF.replace("0.13 -0.05", "0.15 -0.05"), r"the axis of roll is 9\.6 mm and 0\.00° off its place"),
        (MJCF.replace('name="roll" axis="1', 'name="roll" axis="-1'), r"roll is 0\.0 mm and 180\.00° off"),
        (MJCF.replace('"extend" type="slide"', '"extend"'), r"no chain of joints like .* turn, elbow, extend, roll"),
        (MJCF.replace('name="extend"', 'name="shift"'), r"It has elbow, roll, turn\."),
        (inserted('<joint name="extend"', '<joint name="spring"/>'), "each alone in its body"),
        (inserted('<body name="c"', '<joint type="ball"/>'), "none between them"),
        (MJCF.replace('<body name="a"', '<frame><body name="a"').replace("    </body>\n  </w", "</frame></body></w"),
         "the body of turn is in a <frame>"),
    ],
)  # fmt: skip
def test_what_is_not_the_arm_or_cannot_be_changed_is_named(text, message, tmp_path, nominal, corrected):
    assert text != MJCF
    with pytest.raises(RobotError, match=message):
        written(tmp_path, text, nominal, corrected)


def test_bodies_in_another_file_are_not_changed(tmp_path, nominal, corrected):
    (tmp_path / "arm.xml").write_text(MJCF, "utf-8")
    with pytest.raises(RobotError, match="Name the file that it includes"):
        written(tmp_path, '<mujoco><include file="arm.xml"/></mujoco>', nominal, corrected)


def test_two_arms_alike_are_told_apart_only_by_names(tmp_path, nominal, corrected):
    (arm,) = re.findall(r' *<body name="pedestal".*</body>\n(?=  </worldbody>)', MJCF, re.DOTALL)
    other = re.sub(r'name="(\w+)"', r'name="other_\1"', arm)
    both = MJCF.replace(arm, arm + other)
    alone = written(tmp_path, MJCF, nominal, corrected).text
    assert written(tmp_path, both, nominal, corrected).text == alone.replace("  </worldbody>", f"{other}  </worldbody>")
    unnamed = re.sub('"(turn|elbow|extend|roll)"', r'"my_\1"', both)
    with pytest.raises(RobotError, match="several chains with the axes of the arm"):
        written(tmp_path, unnamed, nominal, corrected)


def test_parallel_hinges_do_not_show_the_base(tmp_path):
    parallel = Robot.from_urdf(
        URDF.replace('"0 1 0"', '"0 0 1"').replace('"1 0 0"', '"0 0 1"').replace("0.5", "0"), flange="d"
    )
    text = MJCF.replace("-90", "0").replace('"1 0 0"', '"0 0 1"').replace("28.64788975654116", "0")
    with pytest.raises(RobotError, match="hinges of the arm are all parallel"):
        written(tmp_path, text, parallel, parallel)


def test_export_writes_a_calibration_of_measured_poses_into_an_mjcf(tmp_path, nominal, capsys):
    data = simulate(nominal, kind="point", poses=40, effects={"joint_offset:elbow": 0.01}, seed=1).dataset
    robolaser.calibrate(data, effects=["joint_offset:elbow"]).save(tmp_path / "why")
    (tmp_path / "mine.xml").write_text(MJCF, "utf-8")
    asked = ["--into", str(tmp_path / "mine.xml"), "--output", str(tmp_path / "new.xml")]
    assert main(["export", str(tmp_path / "why"), *asked]) == 0
    assert "contains joint_offset at elbow" in capsys.readouterr().out
    shown = tips((tmp_path / "new.xml").read_text("utf-8"), Q)
    arm = robolaser.load_calibration(tmp_path / "why").robot
    np.testing.assert_allclose(screws(shown), screws(arm.forward(Q)), atol=1e-9)
