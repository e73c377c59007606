"""An arm with a joint that follows another (mimic) leaves robolaser as it is calibrated."""

import xml.etree.ElementTree as ET
from functools import cache

import numpy as np
import pytest
from calibrated import bent
from test_corrected_module import AT_REST, found, loaded

from robolaser import find_robot
from robolaser.export.mjcf import mjcf
from robolaser.export.sdf import flange_by_sdf, sdf
from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, simulate

MIMIC = {"joint": "elbow_joint", "multiplier": "-0.8", "offset": "0.3"}
SIZES = {"joint_offset:elbow_joint.offset": 3e-3, "link_geometry:wrist_2_joint.x": 3e-3}
"""Of an offset before the follower and a placement beyond it."""


@cache
def made():
    """A UR5 whose first wrist joint follows the elbow."""
    urdf = ET.fromstring(find_robot("ur5").urdf)
    (wrist,) = (joint for joint in urdf.findall("joint") if joint.get("name") == "wrist_1_joint")
    ET.SubElement(wrist, "mimic", MIMIC)
    robot = Robot.from_urdf(ET.tostring(urdf, encoding="unicode"), flange="tool0")
    assert "wrist_1_joint" not in robot.joints
    return simulate(robot, kind="point", poses=8, options=CellOptions(speed=0.1), seed=3).dataset


def found_bent():
    """A calibration, and the flange's poses by it."""
    calibration = bent(made(), SIZES)
    model = calibration.model
    return calibration, model.flange(model.parameters.values(calibration.x[None]))[0]


def test_corrected_py_follows():
    calibration = found(AT_REST, made())
    run, model = calibration.model.run, calibration.model
    wanted = model.flange(model.parameters.values(calibration.x[None]))[0]
    *before, last = np.concatenate(run.paths)
    now = {"before": run.q[before][:, None], "time_s": run.time_s[last] - run.time_s.min()}
    T = loaded(calibration)["forward"](run.q[last][None], **now)[0]
    np.testing.assert_allclose(T, wanted[last], rtol=0, atol=1e-9)
    assert np.abs(wanted - run.flange).max() > 1e-4


def test_the_urdf_follows():
    calibration, wanted = found_bent()
    np.testing.assert_allclose(calibration.robot.forward(made().poses.q[None])[0], wanted, rtol=0, atol=1e-9)


def test_mujoco_follows():
    mujoco = pytest.importorskip("mujoco")
    calibration, wanted = found_bent()
    model = mujoco.MjModel.from_xml_string(mjcf(calibration))
    data, robot = mujoco.MjData(model), made().robot
    (tied,) = range(model.neq)
    assert model.eq_type[tied] == mujoco.mjtEq.mjEQ_JOINT
    follower, leader = (model.joint(int(one[tied])) for one in (model.eq_obj1id, model.eq_obj2id))
    for q, T in zip(made().poses.q, wanted, strict=True):
        data.qpos[[model.joint(name).qposadr[0] for name in robot.joints]] = q
        data.qpos[follower.qposadr] = np.polyval(model.eq_data[tied, 4::-1], data.qpos[leader.qposadr])
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.body(robot.flange).xpos, T[:3, 3], rtol=0, atol=1e-9)
        np.testing.assert_allclose(data.body(robot.flange).xmat.reshape(3, 3), T[:3, :3], rtol=0, atol=1e-9)


def test_gazebo_is_told_what_follows_what():
    calibration, wanted = found_bent()
    text = sdf(calibration)
    np.testing.assert_allclose(flange_by_sdf(text, made().robot, made().poses.q), wanted, rtol=0, atol=1e-9)
    root = ET.fromstring(text)
    (mimic,) = root.iter("mimic")
    assert root.get("version") == "1.11"
    stated = {
        "joint": mimic.get("joint"),
        "multiplier": mimic.findtext("multiplier"),
        "offset": mimic.findtext("offset"),
    }
    assert stated == MIMIC
