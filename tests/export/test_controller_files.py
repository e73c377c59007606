"""What a technician types into a controller, what drivers of Universal Robots read, and LeRobot's zeros."""

import csv
import io
import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import yaml
from calibrated import bent

from robolaser.calibration.result import Calibration
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError
from robolaser.export.controller_table import NUMBERS, controller_table, flange_by_table, link, link_parameters
from robolaser.export.into import zeros_into
from robolaser.export.ur_calibration import LINKS, flange_by_ur_calibration, ur_calibration
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose, rot_x, rot_y, rot_z
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation.simulate import simulate

ARMS = ("scorbot_er7", "ur5", "ur10e", "panda", "irb120", "so101", "z1")


def built_otherwise(robot: Robot, rng: np.random.Generator) -> Robot:
    moves = [pose(exp_so3(1e-3 * rng.normal(size=3)), 1e-3 * rng.normal(size=3)) for _ in robot.joints]
    return robot.with_placements(robot.placements @ np.stack(moves), 3e-3 * rng.normal(size=len(robot.joints)))


def by_links(robot: Robot, rows: np.ndarray, first: np.ndarray, q: np.ndarray) -> np.ndarray:
    T = first
    for row, joint in zip(rows, robot.chain, strict=True):
        T = T @ link(row + np.eye(len(NUMBERS))[1 if robot.prismatic[joint] else 0] * q[joint])
    return T


@pytest.mark.parametrize("name", ARMS)
def test_links_carry_the_flange_where_the_arm_has_it(name: str) -> None:
    rng, robot = np.random.default_rng(3), find_robot(name)
    known = link_parameters(robot)
    for arm, (rows, first) in ((robot, known), (other := built_otherwise(robot, rng), link_parameters(other, known))):
        zero = np.zeros(len(robot.joints))
        end = inverse(by_links(arm, rows, first, zero)) @ arm.forward(zero)
        for q in rng.uniform(-1.5, 1.5, (5, len(robot.joints))):
            np.testing.assert_allclose(by_links(arm, rows, first, q) @ end, arm.forward(q), atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_links_of_two_nearly_equal_arms_differ_little(name: str) -> None:
    robot = find_robot(name)
    rows, first = link_parameters(robot)
    changed = link_parameters(built_otherwise(robot, np.random.default_rng(5)), (rows, first))[0] - rows
    changed[:, [0, 3, 4]] = (changed[:, [0, 3, 4]] + np.pi) % (2.0 * np.pi) - np.pi
    assert np.abs(changed).max() < 0.02


@pytest.fixture(scope="module")
def found() -> Calibration:
    made = simulate("ur5", kind="point", poses=6, noise=Noise(point_m=1e-5, joint_step_rad=1e-5), seed=2).dataset
    return bent(made, {"joint_offset:elbow_joint.offset": 0.002, "link_geometry:wrist_1_joint.x": 0.0005})


def test_the_zero_of_a_joint_has_the_sign_of_its_angle(found) -> None:
    rows = list(csv.DictReader(io.StringIO(controller_table(found))))
    (zero,) = [one for one in rows if (one["joint"], one["number"]) == ("elbow_joint", "theta")]
    assert float(zero["correction"]) == pytest.approx(np.degrees(0.002), rel=0.05)
    assert float(zero["corrected"]) == pytest.approx(float(zero["nominal"]) + float(zero["correction"]), abs=2e-6)
    (steps,) = [one for one in rows if (one["joint"], one["number"]) == ("elbow_joint", "zero")]
    assert float(steps["correction"]) == pytest.approx(np.radians(float(zero["correction"])) / 1e-5, abs=0.1)
    (length,) = [one for one in rows if (one["joint"], one["number"]) == ("elbow_joint", "a")]
    assert length["unit"] == "mm"
    assert abs(float(length["correction"])) > 0.3


def test_the_zero_of_a_joint_that_slides_is_its_distance() -> None:
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    text = '<robot name="r"><link name="l0"/>'
    for i, kind in enumerate(("revolute", "prismatic", "revolute"), 1):
        placed = f'<parent link="l{i - 1}"/><child link="l{i}"/><origin xyz="0.3 0.1 0.1" rpy="0.2 {i} 0.1"/>'
        text += f'<link name="l{i}"/><joint name="j{i}" type="{kind}">{placed}<axis xyz="0 0 1"/>{limit}</joint>'
    robot = Robot.from_urdf(f"{text}</robot>", flange="l3")
    data = simulate(robot, kind="point", poses=6, noise=Noise(point_m=1e-5, joint_step_rad=1e-5), seed=2).dataset
    rows = csv.DictReader(io.StringIO(controller_table(bent(data, {"joint_offset:j2.offset": 0.002}))))
    zeros = [(one["joint"], one["number"], one["correction"]) for one in rows if "zero" in one["meaning"]]
    assert zeros == [("j2", "d", "2.000000"), ("j3", "theta", "0.000000")]


def test_both_files_hold_the_corrected_arm(found) -> None:
    robot, corrected = found.model.dataset.robot, found.robot
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (20, 6))
    described = flange_by_ur_calibration(ur_calibration(found), robot, q)
    np.testing.assert_allclose(described, corrected.forward(q), atol=1e-9)
    assert list(LINKS.values()) == list(robot.joints)
    by_table = flange_by_table(controller_table(found), robot, q)
    moved = inverse(by_table[:1]) @ by_table, inverse(corrected.forward(q[:1])) @ corrected.forward(q)
    np.testing.assert_allclose(moved[0], moved[1], atol=2e-6)


MAKERS_OWN = {
    "ur5": (0.089159, -0.425, -0.39225, 0.10915, -0.09465, 0.0823),
    "ur5e": (0.1625, -0.425, -0.3922, 0.1333, -0.0997, 0.0996),
}
"""Of `default_kinematics.yaml` in Universal_Robots_ROS2_Description."""


@pytest.mark.parametrize("name", MAKERS_OWN)
def test_whatever_frames_an_urdf_has_the_yaml_has_the_makers(name: str) -> None:
    found = bent(simulate(name, kind="point", poses=6, seed=2).dataset, {"joint_offset:wrist_2_joint.offset": 0.01})
    links = yaml.safe_load(ur_calibration(found))["kinematics"]
    numbers = (
        ("shoulder", "z"),
        ("forearm", "x"),
        ("wrist_1", "x"),
        ("wrist_1", "z"),
        ("wrist_2", "y"),
        ("wrist_3", "y"),
    )
    assert [links[link][axis] for link, axis in numbers] == pytest.approx(MAKERS_OWN[name], abs=1e-9)
    right = np.array(np.pi / 2)
    for link_name, ideal in (
        ("upper_arm", rot_x(right)),
        ("wrist_2", rot_x(right) @ rot_z(0.01)),
        ("wrist_3", rot_x(-right)),
    ):
        roll, pitch, yaw = (links[link_name][key] for key in ("roll", "pitch", "yaw"))
        np.testing.assert_allclose(rot_z(yaw) @ rot_y(pitch) @ rot_x(roll), ideal, atol=1e-6)


def test_an_arm_of_another_maker_has_no_calibration_yaml() -> None:
    found = bent(simulate("scorbot_er7", kind="point", poses=6, seed=2).dataset, {"joint_offset:joint_3.offset": 2e-3})
    assert ur_calibration(found) is None
    assert controller_table(found)


FINGERS = """
  <link name="left"/><link name="right"/>
  <joint name="grip" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
  <joint name="grip_right" type="prismatic"><parent link="tool0"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" effort="1" velocity="1"/><mimic joint="grip" offset="0.002"/></joint>
</robot>"""


def test_a_gripper_whose_fingers_follow_each_other_takes_no_table_from_the_arm(found) -> None:
    data = found.model.dataset
    text = data.robot.urdf.replace("</robot>", FINGERS)
    robot = Robot.from_urdf(text, flange="tool0", joints=data.robot.joints)
    sizes = {"joint_offset:elbow_joint.offset": 0.002, "link_geometry:wrist_1_joint.x": 0.0005}
    assert controller_table(bent(replace(data, robot=robot), sizes)) == controller_table(found)


SERVO = {"id": 3, "drive_mode": 0, "homing_offset": -562, "range_min": 868, "range_max": 3094}
CALIBRATION = {"elbow_flex": SERVO, "gripper": {**SERVO, "id": 6}}
PLAY = {"effect": "backlash", "where": "elbow_flex", "parameters": {}}


def offset(value: float, where: str = "elbow_flex") -> dict[str, Any]:
    return {"effect": "joint_offset", "where": where, "parameters": {"offset": {"value": value}}}


def read_degrees(actual: int, servo: dict[str, int]) -> float:
    """As LeRobot reads a count, by motors/feetech/feetech.py and motors/motors_bus.py."""
    return (actual - servo["homing_offset"] - (servo["range_min"] + servo["range_max"]) / 2) * 360 / 4095


@pytest.mark.parametrize("angle", [0.05, -0.05])
def test_lerobot_then_reads_what_the_joint_was_found_to_be_at(angle: float) -> None:
    written = zeros_into(json.dumps(CALIBRATION), [offset(angle), PLAY], "my_arm.json")
    changed = json.loads(written.text)
    before, after = (read_degrees(1800, one["elbow_flex"]) for one in (CALIBRATION, changed))
    assert after - before == pytest.approx(math.degrees(angle), abs=360 / 4096)
    assert written.contains == (("joint_offset", "elbow_flex"),)
    assert written.lacks == (("backlash", "elbow_flex"),)
    assert "do not determine" in written.remarks[0]  # no standard error is known
    changed["elbow_flex"]["homing_offset"] = SERVO["homing_offset"]
    assert changed == CALIBRATION


@pytest.mark.parametrize(
    ("text", "effects", "match"),
    [
        ("{", [offset(0.05)], "no calibration file of LeRobot"),
        ('{"elbow_flex": {"deep": ' + "[" * 100_000, [offset(0.05)], "no calibration file of LeRobot"),
        ('{"elbow_flex": {"id": 3}}', [offset(0.05)], "homing_offset"),
        (json.dumps(CALIBRATION), [offset(0.05, "shoulder_pan")], "lacks shoulder_pan"),
        (json.dumps(CALIBRATION), [{**offset(0.05), "parameters": {}}], "joint_offset of elbow_flex has no offset"),
        (json.dumps(CALIBRATION), [PLAY], "no joint with a wrong zero"),
        (json.dumps({"elbow_flex": {**SERVO, "homing_offset": -2040}}), [offset(0.05)], "would become -2073"),
    ],
)
def test_what_cannot_be_written_is_refused(text: str, effects: list[dict[str, Any]], match: str) -> None:
    with pytest.raises(DataError, match=match):
        zeros_into(text, effects, "my_arm.json")
