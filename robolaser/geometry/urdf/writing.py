"""A robot's description rewritten with care: what is not changed stays as its author wrote it."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import rot_z
from robolaser.geometry.urdf.parsing import parse, read_xml
from robolaser.geometry.urdf.tree import Tree, unknown_frame, unknown_joint

_PROLOGUE = re.compile(r"\s*(?:<\?.*?\?>\s*|<!--.*?-->\s*)*", re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def with_fixed_frame(text: str, parent: str, name: str, T_parent_child: Array) -> str:
    """Add a link `name` that sits still on the link `parent`.

    Args:
        text: A URDF.
        parent: An existing link.
        name: The new link; its joint is called `name_joint`, or numbered if that is taken.
        T_parent_child: Where it sits, (4, 4).

    Raises:
        RobotError: There is no such parent, or `name` is taken.
    """
    tree = parse(text)
    if parent not in tree.links:
        raise unknown_frame(tree.source, parent, tree.links)
    if name in tree.links:
        raise RobotError(f"{tree.source} has a frame '{name}' already. Choose another name for the new one.")
    joint_name, count = f"{name}_joint", 2
    while joint_name in tree.joints:
        joint_name, count = f"{name}_joint_{count}", count + 1
    robot = read_xml(text, tree.source)
    ET.SubElement(robot, "link", name=name).tail = "\n"
    joint = ET.SubElement(robot, "joint", name=joint_name, type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=name)
    ET.SubElement(joint, "origin", origin_attributes(T_parent_child))
    joint.tail = "\n"
    return _written(robot, text)


def with_placements(text: str, placements: Mapping[str, Array]) -> str:
    """Replace the origins of joints, by name, each (4, 4) on its parent link; the rest stays as it is.

    Raises:
        RobotError: There is no such joint.
    """
    tree = parse(text)
    for name in placements:
        if name not in tree.joints:
            raise unknown_joint(tree.source, name, tree.joints)
    robot = read_xml(text, tree.source)
    for joint in robot.findall("joint"):
        name = joint.get("name", "")
        if name in placements:
            origin = joint.find("origin")
            origin = ET.SubElement(joint, "origin") if origin is None else origin
            origin.attrib.clear()
            origin.attrib.update(origin_attributes(placements[name]))
    return _written(robot, text)


def minimal(tree: Tree, moving: Mapping[str, str]) -> str:
    """Write the tree anew from its checked values alone, for a parser that trusts what it reads.

    Args:
        tree: A checked URDF.
        moving: New names of the joints that may move; all others are held at neutral.
    """
    number = {link: f"link_{i}" for i, link in enumerate(tree.links)}
    robot = ET.Element("robot", name="robot")
    for link in tree.links.values():
        element = ET.SubElement(robot, "link", name=number[link.name])
        if link.mass > 0:
            inertial = ET.SubElement(element, "inertial")
            ET.SubElement(inertial, "origin", xyz=digits(link.com))
            ET.SubElement(inertial, "mass", value=repr(link.mass))
            ET.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")
    for i, joint in enumerate(tree.joints.values()):
        free = joint.name in moving
        kind = ("prismatic" if joint.kind == "prismatic" else "revolute") if free else "fixed"
        element = ET.SubElement(robot, "joint", name=moving.get(joint.name, f"held_{i}"), type=kind)
        ET.SubElement(element, "parent", link=number[joint.parent])
        ET.SubElement(element, "child", link=number[joint.child])
        ET.SubElement(element, "origin", origin_attributes(joint.origin))
        if free:
            ET.SubElement(element, "axis", xyz=digits(joint.axis))
            ET.SubElement(element, "limit", lower="-1e9", upper="1e9", effort="1e9", velocity="1e9")
    return ET.tostring(robot, encoding="unicode")


def origin_attributes(T: Array) -> dict[str, str]:
    """What `<origin>` says of a placement (4, 4), to the last bit."""
    return {"xyz": digits(T[:3, 3]), "rpy": digits(_rpy(T[:3, :3]))}


def _rpy(R: Array) -> Array:
    """Roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll); at the pole, where yaw is free, exact too."""
    yaw = np.arctan2(R[1, 0], R[0, 0])
    rest = rot_z(-yaw) @ R
    return np.array([np.arctan2(-rest[1, 2], rest[1, 1]), np.arctan2(-rest[2, 0], rest[0, 0]), yaw])


def digits(values: Array) -> str:
    """Numbers to the last bit."""
    return " ".join(repr(float(value)) for value in np.ravel(values))


def _written(robot: ET.Element, before: str) -> str:
    """XML text of `robot`, under the comments (a licence, often) that stood above it in the text `before`."""
    prologue = _PROLOGUE.match(before)
    comments = _COMMENT.findall(prologue[0]) if prologue else []
    return "\n".join(['<?xml version="1.0"?>', *comments, ET.tostring(robot, encoding="unicode"), ""])
