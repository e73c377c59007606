"""An arm of one chain of turning joints, written as a URDF."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.urdf.writing import origin_attributes


@final
@dataclass(frozen=True, eq=False)
class Segment:
    """A joint and the link that it turns.

    Attributes:
        joint: Its name.
        placement: Of the joint, on the frame of the joint before or on the base, (4, 4).
        axis: In the joint's frame; the reading grows as it turns right-handed about it, (3,).
        limits: Least and largest reading [rad]; infinite where there are none.
        mass: Of the link [kg].
        com: The link's centre of mass in the joint's frame, (3,) [m].
    """

    joint: str
    placement: Array
    axis: Array
    limits: tuple[float, float]
    mass: float
    com: Array


def serial_urdf(segments: Sequence[Segment], end: Array, name: str, base: str, flange: str) -> str:
    """Write a chain as a URDF; efforts, speeds and moments of inertia are not known and written as zero.

    Args:
        segments: From the base to the flange.
        end: The flange on the last joint's frame, (4, 4).
        name: Of the robot.
        base: What the first link is called; the others are `link_1` and so on.
        flange: What the last link is called.
    """
    robot = ET.Element("robot", name=name)
    ET.SubElement(robot, "link", name=base)
    parent = base
    for number, segment in enumerate(segments, 1):
        child = f"link_{number}"
        inertial = ET.SubElement(ET.SubElement(robot, "link", name=child), "inertial")
        ET.SubElement(inertial, "origin", xyz=_digits(segment.com))
        ET.SubElement(inertial, "mass", value=repr(float(segment.mass)))
        ET.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
        limited = bool(np.isfinite(segment.limits).all())
        kind = "revolute" if limited else "continuous"
        joint = _joint(robot, segment.joint, kind, parent, child, segment.placement)
        ET.SubElement(joint, "axis", xyz=_digits(segment.axis))
        if limited:
            lower, upper = map(repr, map(float, segment.limits))
            ET.SubElement(joint, "limit", lower=lower, upper=upper, effort="0", velocity="0")
        parent = child
    ET.SubElement(robot, "link", name=flange)
    _joint(robot, f"{flange}_joint", "fixed", parent, flange, end)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def _joint(robot: ET.Element, name: str, kind: str, parent: str, child: str, T: Array) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", origin_attributes(T))
    return joint


def _digits(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)
