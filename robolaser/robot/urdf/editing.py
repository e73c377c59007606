"""Edits of a robot's description: unchanged parts stay as their author wrote them."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from robolaser.arrays import Array
from robolaser.errors import RobotError, near
from robolaser.robot.urdf.checking import MOST_LISTED, read_xml, unknown_frame
from robolaser.robot.urdf.elements import add_fixed, origin_attributes
from robolaser.robot.urdf.markup import with_changes


def names_in(robot: ET.Element, kind: str) -> list[str]:
    """The names of all links, or all joints, of a URDF."""
    return [element.get("name", "") for element in robot.findall(kind)]


def with_fixed_frames(text: str, parent: str, frames: Mapping[str, Array]) -> str:
    """Add links that are fixed to the link `parent`, at T_parent_child (4, 4) by their names.

    A name that is taken gets a number, as does the link's joint, `NAME_joint`.

    Raises:
        RobotError: There is no such parent.
    """
    robot = read_xml(text)
    links, joints = names_in(robot, "link"), names_in(robot, "joint")
    if parent not in links:
        raise unknown_frame("the URDF", parent, links)
    for wanted, T_parent_child in frames.items():
        name = _free(wanted, links)
        joint = _free(f"{name}_joint", joints)
        ET.SubElement(robot, "link", name=name)
        add_fixed(robot, joint, parent, name, T_parent_child)
        links.append(name)
        joints.append(joint)
    return with_changes(text, robot)


def with_placements(text: str, placements: Mapping[str, Array]) -> str:
    """Replace the origins of joints, by name, each (4, 4) on its parent link.

    Raises:
        RobotError: There is no such joint.
    """
    robot = read_xml(text)
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    for name, T in placements.items():
        if name not in joints:
            raise RobotError(f"No joint '{name}' in the URDF.{near(name, joints, MOST_LISTED)}")
        origin = joints[name].find("origin")
        origin = ET.SubElement(joints[name], "origin") if origin is None else origin
        origin.attrib.clear()
        origin.attrib.update(origin_attributes(T))
    return with_changes(text, robot)


def _free(name: str, taken: list[str]) -> str:
    free, count = name, 2
    while free in taken:
        free, count = f"{name}_{count}", count + 1
    return free
