"""A result in a copy of the user's own robot."""

import json
import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pytest

import robolaser
from robolaser.cli import main
from robolaser.errors import RobotError
from robolaser.export.into import motion_into, placements_into
from robolaser.export.servo_table import less_hold
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate


def effect(name: str, where: str, **numbers: float) -> dict[str, Any]:
    parameters = {key: {"value": value, "std": None, "unit": ""} for key, value in numbers.items()}
    return {"effect": name, "where": where, "parameters": parameters}


FOUND = [
    effect("viscous_friction", "lift", factor=0.5), effect("rotor_inertia", "lift", inertia=0.02),
    effect("droop", "lift", compliance=0.05), effect("lag", "lift", time=0.06),
    effect("dead_time", "lift", delay=0.03), effect("dead_zone", "lift", half_width=0.01),
    effect("offset", "lift", angle=0.02), effect("clock_shift", "timing", delay=0.002),
]  # fmt: skip
MJCF = """
<mujoco><!-- mine --><option timestep="0.001" gravity="0 0 0"/>
<worldbody><body name="arm"><joint name="lift" axis="0 1 0"/>
<inertial mass="1" pos="0.1 0 0" diaginertia="0.01 0.01 0.01"/></body></worldbody>
<actuator><position joint="lift" kp="5"/></actuator></mujoco>
"""


@pytest.fixture(scope="module")
def written() -> ET.Element:
    return ET.fromstring(motion_into(MJCF, FOUND, "arm.xml").text)


def test_joints_get_friction_and_inertia(written):
    (joint,) = written.iter("joint")
    assert float(joint.get("damping", 0)) == 0.5
    assert float(joint.get("armature", 0)) == 0.02
    assert float(joint.get("frictionloss", 0)) == pytest.approx(20.0 * 0.01)


def test_servos_get_gains_and_a_delay(written):
    (servo,) = written.iter("position")
    assert float(servo.get("kp", 0)) == pytest.approx(20.0)
    assert float(servo.get("kv", 0)) == pytest.approx(1.2)
    assert float(servo.get("delay", 0)) == 0.03


@pytest.mark.parametrize(
    ("servo", "effects", "kp", "kv"),
    [
        ('kp="5" kv="0.1"', ["droop"], 20.0, 0.4),
        ('kp="5" dampratio="1"', ["lag"], 5.0, 0.3),
        ('class="inner"', ["lag"], 8.0, 0.48),
        ('class="inner"', ["droop"], 20.0, 0.5),
    ],
)
def test_a_servo_keeps_its_lag_and_the_gains_of_its_class(servo, effects, kp, kv):
    defaults = '<default><position kp="3" kv="0.2"/><default class="inner"><position kp="8"/></default></default>'
    text = MJCF.replace('joint="lift" kp="5"', f'joint="lift" {servo}').replace("<worldbody>", f"{defaults}<worldbody>")
    text = motion_into(text, [one for one in FOUND if one["effect"] in effects], "arm.xml").text
    model = pytest.importorskip("mujoco").MjModel.from_xml_string(text)
    np.testing.assert_allclose([model.actuator_gainprm[0, 0], -model.actuator_biasprm[0, 2]], [kp, kv], rtol=1e-9)


@pytest.mark.parametrize(
    ("servo", "ends", "expected"),
    [
        ('ctrlrange="-1.5 1.5"', {"upper": 1.2}, "-1.5 1.2"),
        ('ctrlrange="-1.5 1.5"', {"lower": -1.0}, "-1.0 1.5"),
        ('inheritrange="1"', {"lower": -1.0, "upper": 1.2}, "-1.0 1.2"),
        ("", {"upper": 1.2}, "-7.0 1.2"),
    ],
)
def test_a_limit_that_was_found_leaves_the_other_end_of_the_servos_range(servo, ends, expected):
    mujoco = pytest.importorskip("mujoco")
    text = MJCF.replace('kp="5"', f'kp="5" {servo}').replace('axis="0 1 0"', 'axis="0 1 0" range="-2 2"')
    copy = motion_into(text, [effect("range_limit", "lift", **ends)], "arm.xml").text
    assert ET.fromstring(copy)[2][0].get("ctrlrange") == expected
    assert mujoco.MjModel.from_xml_string(copy).actuator_ctrlrange[0].tolist() == [*map(float, expected.split())]


def test_a_dead_zone_replaces_friction_that_the_file_guessed():
    text = MJCF.replace('axis="0 1 0"', 'axis="0 1 0" frictionloss="0.9"')
    written = motion_into(text, [effect("dead_zone", "lift", half_width=0.01)], "arm.xml")
    (joint,) = ET.fromstring(written.text).iter("joint")
    assert float(joint.get("frictionloss", 0)) == pytest.approx(5.0 * 0.01)


def test_a_joint_that_rises_under_load_is_no_stiffness_of_a_servo():
    written = motion_into(MJCF, [effect("droop", "lift", compliance=-0.1)], "arm.xml")
    assert written.lacks == (("droop", "lift"),)
    assert 'kp="5"' in written.text


def test_text_where_a_gain_should_be_is_named():
    with pytest.raises(RobotError, match=r"arm\.xml: kp of lift is 'stiff'; expected a number"):
        motion_into(MJCF.replace('kp="5"', 'kp="stiff"'), FOUND, "arm.xml")


def test_mujoco_moves_the_copy_late_and_slowly():
    mujoco = pytest.importorskip("mujoco", minversion="3.5")  # actuators have no delay before

    def after(text: str, seconds: float) -> float:
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)
        data.ctrl[:] = 0.5
        while data.time < seconds:
            mujoco.mj_step(model, data)
        return float(data.qpos[0])

    copy = motion_into(MJCF, FOUND, "arm.xml").text
    assert after(copy, 0.025) == 0.0
    assert after(MJCF, 0.025) > 0.0
    assert after(copy, 2.0) == pytest.approx(0.5, abs=0.011)  # the dead zone


def test_what_a_file_has_no_place_for_is_said():
    copy = motion_into(MJCF, FOUND, "arm.xml")
    assert set(copy.lacks) == {("offset", "lift"), ("clock_shift", "timing")}
    assert len(copy.contains) == len(FOUND) - 2


@pytest.mark.parametrize("where", ["tool", "timing", "joints", "base"])
def test_what_is_at_no_joint_is_lacking_also_where_it_is_alone(where):
    assert motion_into(MJCF, [effect("torque_constant", where, factor=0.1)], "arm.xml").lacks == (
        ("torque_constant", where),
    )


def test_an_actuator_of_another_kind_is_said_to_take_no_servo():
    general = MJCF.replace('<position joint="lift" kp="5"/>', '<general joint="lift" gainprm="5"/>')
    copy = motion_into(general, FOUND, "arm.xml")
    assert ("lag", "lift") in copy.lacks
    assert copy.remarks == ("arm.xml has no <position> actuator of lift: only such ones take effects of servos.",)
    assert motion_into(MJCF, FOUND, "arm.xml").remarks == ()


def test_a_simulator_that_holds_commands_gets_a_row_less_of_delay():
    found = [
        effect("lag", "lift", time=0.06),
        effect("dead_time", "lift", delay=0.015),
        effect("lag", "pan", time=0.01),
    ]
    held = less_hold([*found, effect("dead_zone", "pan", half_width=0.01)], 0.02)
    sizes = [number["value"] for one in held for number in one["parameters"].values()]
    assert sizes == pytest.approx([0.055, 0.0, 0.0, 0.01])
    assert [one["parameters"] for one in less_hold(found, 0.0)] == [one["parameters"] for one in found]


WRITTEN = """<?xml version="1.0"?>
<!-- licence -->
<mujoco model = 'arm'>
  <worldbody><body><joint name='lift'   axis="0 1 0" /><!-- <joint name="lift"/> --></body></worldbody>
  <actuator>
    <position kp="5" name="a &amp; b"
              joint='lift'/>
  </actuator>
</mujoco>
"""


def test_what_is_not_changed_stays_as_its_author_wrote_it():
    found = [effect("viscous_friction", "lift", factor=0.5), effect("droop", "lift", compliance=0.05)]
    expected = WRITTEN.replace('kp="5"', 'kp="20.0"').replace('axis="0 1 0"', 'axis="0 1 0" damping="0.5"')
    assert motion_into(WRITTEN, found, "arm.xml").text == expected
    urdf = '<robot name="r">\n  <joint name="lift" type="fixed"/>\n  <joint name="low" >\n  </joint>\n</robot>'
    friction = [effect("viscous_friction", where, factor=0.5) for where in ("lift", "low")]
    added = '<dynamics damping="0.5" />'
    expected = urdf.replace('"fixed"/>', f'"fixed">{added}</joint>').replace('"low" >', f'"low" >\n    {added}')
    assert motion_into(urdf, friction, "arm.urdf").text == expected


def test_a_urdf_takes_friction():
    robot = find_robot("ur5")
    copy = motion_into(robot.urdf, [effect("viscous_friction", "elbow_joint", factor=3.0)], "ur5.urdf")
    (joint,) = [one for one in ET.fromstring(copy.text).findall("joint") if one.get("name") == "elbow_joint"]
    assert float(joint.find("dynamics").get("damping", 0)) == 3.0


def test_another_robot_is_refused():
    with pytest.raises(RobotError, match="none of the joints"):
        motion_into(find_robot("ur5").urdf, FOUND, "ur5.urdf")


def test_placements_of_joints_go_into_the_users_urdf(tmp_path, capsys):
    arm = find_robot("ur5")
    data = simulate(arm, kind="point", poses=30, effects={"joint_offset:elbow_joint": 0.01}, seed=1).dataset
    robolaser.calibrate(data, effects=["joint_offset:elbow_joint"]).save(tmp_path / "why")
    mine = tmp_path / "mine.urdf"
    mine.write_text(arm.urdf.replace("<robot", "<!-- mine --><robot", 1), encoding="utf-8")
    asked = ["export", str(tmp_path / "why"), "--into", str(mine), "--output", str(tmp_path / "new.urdf")]
    assert main([*asked, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["contains"] == [["joint_offset", "elbow_joint"]]
    new = Robot.from_urdf((tmp_path / "new.urdf").read_text(encoding="utf-8"), flange=arm.flange)
    q = np.zeros((1, 1, 6))
    turned = q + 0.01 * np.eye(6)[2]
    assert np.allclose(new.forward(q), arm.forward(turned), atol=2e-4)
    assert main(asked) == 1  # the copy is there already
    assert "--force" in capsys.readouterr().err


def test_a_robot_that_shares_only_other_joints_gets_no_copy(tmp_path):
    arm = find_robot("ur5")
    data = simulate(arm, kind="point", poses=30, effects={"joint_offset:elbow_joint": 0.01}, seed=1).dataset
    found = robolaser.calibrate(data, effects=["joint_offset:elbow_joint"])
    corrected = found.files()["robot_corrected.urdf"]
    assert corrected is not None
    other = arm.urdf.replace('"elbow_joint"', '"another_joint"')
    with pytest.raises(RobotError, match=r"none of the joints of the result: elbow_joint\."):
        placements_into(other, corrected, found.to_dict()["effects"], "other.urdf")


def test_a_replay_that_mujoco_refuses_leaves_no_copy(tmp_path, capsys):
    pytest.importorskip("mujoco")
    log, arm = tmp_path / "log", find_robot("ur5e")
    assert main(["simulate", "--robot", "ur5e", "--sensor", "motion", "--output", str(log), "--quiet"]) == 0
    found = effect("viscous_friction", "elbow_joint", factor=3.0)
    found = {"format": "robolaser-diagnosis/1", "kind": "motion", "effects": [found]}
    (tmp_path / "diagnosis.json").write_text(json.dumps(found), encoding="utf-8")
    (tmp_path / "mine.urdf").write_text(arm.urdf, encoding="utf-8")  # has masses that MuJoCo does not take
    asked = ["--into", str(tmp_path / "mine.urdf"), "--output", str(tmp_path / "real.urdf"), "--replay", str(log)]
    assert main(["export", str(tmp_path / "diagnosis.json"), *asked]) == 1
    assert "MuJoCo cannot load mine.urdf" in capsys.readouterr().err
    assert not (tmp_path / "real.urdf").exists()
