"""What simulators get of a calibration must move as the model does."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from calibrated import bent, stripe

from robolaser import find_robot
from robolaser.export.mjcf import mjcf
from robolaser.export.sdf import flange_by_sdf, sdf
from robolaser.geometry.rigid_motion import exp_so3, pose, rot_x, rot_y, rot_z
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

GEOMETRY = {"joint_offset:shoulder_lift_joint.offset": 4e-3, "link_geometry:elbow_joint.x": 3e-3,
            "link_geometry:elbow_joint.turn_y": 5e-3}  # fmt: skip
EFFECTS = {
    "offset and placement": GEOMETRY,
    "encoder scale": {"encoder_scale:elbow_joint.scale": 2e-3},
    "eccentricity": {"encoder_eccentricity:elbow_joint.sine": 2e-3, "encoder_eccentricity:elbow_joint.cosine": -1e-3},
    "transmission": {"transmission_error:elbow_joint.sine": 2e-3, "transmission_error:elbow_joint.cosine_2": 1e-3},
    "coupling": {"joint_coupling:wrist_2_joint.ratio": 4e-3, "joint_coupling:wrist_2_joint.home": -0.25,
                 "joint_coupling:wrist_2_joint.other": 4.0},
    "coupling of a joint whose encoder has another scale": {
        "encoder_scale:wrist_2_joint.scale": 2e-3, "joint_coupling:wrist_2_joint.ratio": 4e-3,
        "joint_coupling:wrist_2_joint.home": -0.25, "joint_coupling:wrist_2_joint.other": 4.0,
    },
    "backlash": {"backlash:shoulder_lift_joint.lost_motion": 3e-3, "backlash:shoulder_lift_joint.start": 0.4},
    "settling": {"settling:elbow_joint.share": 3e-3},
    "compliance": {"joint_compliance:shoulder_lift_joint.compliance": 4e-5},
    "compliance, hardening, with a payload": {
        "joint_compliance:elbow_joint.compliance": 4e-5, "joint_compliance:elbow_joint.payload": 6e-5,
        "joint_compliance:elbow_joint.hardening": 0.3,
    },
    "base": {"base_compliance:base.compliance": 2e-5, "base_compliance:base.anisotropy": 0.3,
             "base_compliance:base.depth": 0.4},
    "base and encoder scale": {"base_compliance:base.compliance": 2e-6,
                               "encoder_scale:shoulder_lift_joint.scale": 1e-3},
}  # fmt: skip


@cache
def made():
    return simulate(find_robot("ur5"), kind="point", poses=6, seed=3).dataset


def wanted(calibration):
    return calibration.model.flange(calibration.model.parameters.values(calibration.x[None]))[0]


def test_without_a_robot_there_is_nothing_to_simulate():
    assert mjcf(stripe()) is None
    assert sdf(stripe()) is None


def test_what_cannot_be_contained_is_said():
    calibration = bent(made(), {"thermal_drift:elbow_joint.growth": 1e-3})
    assert "Not contained: the link before elbow_joint expands" in mjcf(calibration)


def test_what_stands_between_joints_has_names_that_the_urdf_does_not_have():
    robot = made().robot
    text = robot.urdf.replace("tool0", "payload").replace("wrist_3_joint", "elbow_joint_play")
    renamed = replace(made(), robot=Robot.from_urdf(text, flange="payload", gravity=robot.gravity))
    root = ET.fromstring(mjcf(bent(renamed, {"backlash:elbow_joint.lost_motion": 3e-3})))
    joints = [joint.get("name") for joint in root.iter("joint") if joint.get("name")]
    assert len(joints) == len(set(joints))
    assert {"elbow_joint_play", "elbow_joint_play_"} < set(joints)


def numbers(text):
    return np.array([float(word) for word in text.split()])


def test_the_sdf_has_the_geometry():
    calibration = bent(made(), GEOMETRY | {"joint_compliance:elbow_joint.compliance": 4e-5})
    root = ET.fromstring(sdf(calibration))
    above = {joint.findtext("child"): joint for joint in root.iter("joint")}
    placed = {link.get("name"): link.findtext("pose") for link in root.iter("link")}
    for q, T_wanted in zip(made().poses.q, wanted(bent(made(), GEOMETRY)), strict=True):
        T, link = np.eye(4), made().robot.flange
        while above[link].findtext("parent") != "world":
            at, joint = numbers(placed[link]), above[link]
            motion = np.eye(4)
            if joint.get("type") == "revolute":
                angle = q[made().robot.joints.index(joint.get("name"))]
                motion = pose(exp_so3(angle * numbers(joint.findtext("axis/xyz"))), np.zeros(3))
            T = pose(rot_z(at[5]) @ rot_y(at[4]) @ rot_x(at[3]), at[:3]) @ motion @ T
            link = joint.findtext("parent")
        np.testing.assert_allclose(T, T_wanted, atol=1e-9)
    assert "Not contained: elbow_joint deflects" in sdf(calibration)
    read = flange_by_sdf(sdf(calibration), made().robot, made().poses.q)
    np.testing.assert_allclose(read, wanted(bent(made(), GEOMETRY)), atol=1e-9)


def test_the_sdf_of_an_arm_that_slides_is_read_as_it_is():
    dataset = simulate(find_robot("tiago"), kind="point", poses=6, seed=3).dataset
    read = flange_by_sdf(sdf(bent(dataset, {})), dataset.robot, dataset.poses.q)
    np.testing.assert_allclose(read, dataset.flange(), atol=1e-9)


def replayed(text, q, *, settle_s):
    """T_base_flange at joint values along a path, where MuJoCo brings the arm to rest, (n, 4, 4)."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    columns = [model.joint(name).qposadr[0] for name in made().robot.joints]
    model.dof_armature[columns] = 1e6  # the drives are where they are told to be
    flange, out = model.body(made().robot.flange).id, []
    data.qpos[columns] = q[0]
    for before, goal in zip([q[0], *q], q, strict=False):
        steps = round(settle_s / model.opt.timestep)
        for share in np.minimum(1.5 * np.arange(1, steps + 1) / max(steps, 1), 1.0):
            now = before + (1.0 - np.cos(np.pi * share)) / 2 * (goal - before)
            data.qvel[columns] = (now - data.qpos[columns]) / model.opt.timestep
            mujoco.mj_step(model, data)
        data.qpos[columns] = goal
        mujoco.mj_forward(model, data)
        out.append(np.eye(4))
        out[-1][:3, :3], out[-1][:3, 3] = data.xmat[flange].reshape(3, 3), data.xpos[flange]
    return np.array(out)


def test_mujoco_has_the_geometry_within_a_micrometre():
    calibration = bent(made(), GEOMETRY)
    text = mjcf(calibration)
    np.testing.assert_allclose(replayed(text, made().poses.q, settle_s=0), wanted(calibration), atol=1e-6)


MOVED = ("coupling", "encoder scale", "compliance", "compliance, hardening, with a payload", "base", "backlash",
         "base and encoder scale")  # fmt: skip


@pytest.mark.parametrize("name", MOVED)
def test_mujoco_moves_within_five_percent_of_an_effect(name):
    size = {key: value for key, value in EFFECTS[name].items() if not key.endswith(("hardening", "start"))}
    calibration = bent(made(), size)
    order = np.concatenate(calibration.model.run.paths)
    q = made().poses.q[order]
    effect = (wanted(calibration) - made().flange())[order]
    found = replayed(mjcf(calibration), q, settle_s=4.0) - made().flange()[order]
    later = slice(1, None) if name == "backlash" else slice(None)
    assert np.abs(found - effect)[later].max() < 0.05 * np.abs(effect).max()


def test_the_weight_of_the_arm_does_not_creep_through_two_gears_with_play():
    mujoco = pytest.importorskip("mujoco")
    dataset = simulate(find_robot("panda"), kind="point", poses=12, seed=3).dataset
    played = ("panda_joint2", "panda_joint4")
    text = mjcf(bent(dataset, {f"backlash:{joint}.lost_motion": 3e-3 for joint in played}))
    model = mujoco.MjModel.from_xml_string(text)
    data, columns = mujoco.MjData(model), [int(model.joint(name).qposadr[0]) for name in dataset.robot.joints]
    model.dof_armature[columns] = 1e6
    data.qpos[columns] = dataset.poses.q[0]
    for _ in range(250):
        mujoco.mj_step(model, data)
    assert np.abs([data.joint(f"{joint}_play").qpos[0] for joint in played]).max() < 1e-5
