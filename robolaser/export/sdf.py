"""The calibrated arm for Gazebo (SDF): its geometry, its masses and the sensor's frames."""

import xml.etree.ElementTree as ET

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.bodies import RigidBody, bodies
from robolaser.export.corrected_arm import CorrectedArm, comment
from robolaser.geometry.rigid_motion import exp_so3, pose, rot_x, rot_y, rot_z
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.elements import digits, origin_attributes

VERSION = "1.7"  # the first in which a pose can be relative to a link
MIMIC_VERSION = "1.11"  # the first in which a joint can follow another
LEAST_KG = 1e-6  # mass of a massless frame: an engine requires some


def sdf(calibration: Calibration) -> str | None:
    """The robot with corrected offsets and placements of joints, the rest named in comments; None without a robot.

    The root link is fixed to the world, joints that are no columns of q are fixed at neutral, meshes are omitted.
    """
    if calibration.model.dataset.robot is None:
        return None
    arm = CorrectedArm(calibration)
    root = ET.Element("sdf", version=VERSION)
    for one, _ in arm.effects:
        if not one.effect.in_urdf:
            root.append(ET.Comment(f" Not contained: {comment(arm.with_numbers(one))}. "))
    model = ET.SubElement(root, "model", name=arm.robot.name)
    for body in bodies(arm.urdf, arm.robot):
        if body.joint is not None and body.joint.follows is not None:
            root.set("version", MIMIC_VERSION)
        _link(model, body)
        _joint(model, body)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def flange_by_sdf(text: str, robot: Robot, q: Array) -> Array:
    """T_base_flange of an SDF, (n, j) -> (n, 4, 4); the robot names the flange and the joints that are read."""
    root = ET.fromstring(text)
    placed = {link.get("name"): link.find("pose") for link in root.iter("link")}
    above = {joint.findtext("child"): joint for joint in root.iter("joint")}
    T, link = np.tile(np.eye(4), (len(q), 1, 1)), _name(robot.flange)
    while (at := placed[link]) is not None:
        roll, pitch, yaw = (xyz_rpy := _numbers(at.text))[3:]
        on_parent = pose(rot_z(yaw) @ rot_y(pitch) @ rot_x(roll), xyz_rpy[:3])
        T, link = on_parent @ _moved(above[link], robot, q) @ T, at.get("relative_to", "")
    return np.asarray(T)


def _moved(joint: ET.Element, robot: Robot, q: Array) -> Array:
    """Motion of the link by its joint, (n, 4, 4)."""
    axis = joint.find("axis")
    if axis is None:
        return np.tile(np.eye(4), (len(q), 1, 1))
    mimic = axis.find("mimic")
    leader = (joint.get("name") if mimic is None else mimic.get("joint")) or ""
    value = q[:, robot.joints.index(leader)]
    if mimic is not None:
        factor, reference, offset = (float(mimic.findtext(key, "0")) for key in ("multiplier", "reference", "offset"))
        value = factor * (value - reference) + offset
    way = value[:, None] * _numbers(axis.findtext("xyz"))
    if joint.get("type") == "prismatic":
        return pose(np.tile(np.eye(3), (len(q), 1, 1)), way)
    return pose(exp_so3(way), np.zeros_like(way))


def _numbers(text: str | None) -> Array:
    return np.array((text or "").split(), dtype=float)


def _name(link: str | None) -> str:
    """SDF reserves the name `world` for the root's support."""
    return "world" if link is None else "world_link" if link == "world" else link


def _link(model: ET.Element, body: RigidBody) -> None:
    link = ET.SubElement(model, "link", name=_name(body.name))
    if body.parent is not None:
        placed = origin_attributes(body.T)
        ET.SubElement(link, "pose", relative_to=_name(body.parent)).text = f"{placed['xyz']} {placed['rpy']}"
    inertial = ET.SubElement(link, "inertial")
    mass = max(body.mass, LEAST_KG)
    ET.SubElement(inertial, "pose").text = digits(np.array([*body.com, 0.0, 0.0, 0.0]))
    ET.SubElement(inertial, "mass").text = repr(mass)
    inertia = ET.SubElement(inertial, "inertia")
    tensor = body.inertia if body.mass > 0 else LEAST_KG * np.eye(3)
    for key, i, j in (("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2)):
        ET.SubElement(inertia, key).text = digits(tensor[i, j])


def _joint(model: ET.Element, body: RigidBody) -> None:
    moves = body.joint
    kind = "fixed" if moves is None else "prismatic" if moves.slides else "revolute"
    joint = ET.SubElement(model, "joint", name=moves.name if moves else f"{_name(body.name)}_fixed", type=kind)
    ET.SubElement(joint, "parent").text = _name(body.parent)
    ET.SubElement(joint, "child").text = _name(body.name)
    if moves is not None:
        axis = ET.SubElement(joint, "axis")
        ET.SubElement(axis, "xyz").text = digits(moves.axis)
        limit = ET.SubElement(axis, "limit")
        for key, value in zip(("lower", "upper"), moves.limits.tolist(), strict=True):
            ET.SubElement(limit, key).text = repr(value)
        if moves.follows is not None:
            mimic = ET.SubElement(axis, "mimic", joint=moves.follows.other)
            ET.SubElement(mimic, "multiplier").text = repr(moves.follows.ratio)
            ET.SubElement(mimic, "offset").text = repr(moves.follows.offset)
            ET.SubElement(mimic, "reference").text = "0"
