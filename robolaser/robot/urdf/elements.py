"""The elements of a URDF that is written anew: links with masses, joints with placements and limits."""

import math
import xml.etree.ElementTree as ET

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import rot_z

FARTHEST_SLIDE_M = 1e5  # limit of a sliding joint without limits: a URDF demands some


def add_link(robot: ET.Element, name: str, mass: float = 0.0, com: Array | None = None) -> None:
    """A link; of one that weighs something, the mass [kg] at its centre of mass (3,) [m]."""
    link = ET.SubElement(robot, "link", name=name)
    if mass > 0 and com is not None:
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "origin", xyz=digits(com))
        ET.SubElement(inertial, "mass", value=repr(mass))
        ET.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))


def add_fixed(robot: ET.Element, name: str, parent: str, child: str, T: Array, kind: str = "fixed") -> ET.Element:
    """A joint that does not move the link `child` on the link `parent`, where it is placed at T (4, 4)."""
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", origin_attributes(T))
    return joint


def add_moving(
    robot: ET.Element,
    name: str,
    parent: str,
    child: str,
    T: Array,
    axis: Array,
    limits: tuple[float, float] = (-math.inf, math.inf),
    *,
    slides: bool = False,
) -> None:
    """A joint that turns or slides along an axis (3,), within limits [rad] or [m]; infinite ones are none."""
    limited = all(map(math.isfinite, limits))
    joint = add_fixed(robot, name, parent, child, T, "prismatic" if slides else "revolute" if limited else "continuous")
    ET.SubElement(joint, "axis", xyz=digits(axis))
    if slides and not limited:
        limits, limited = (-FARTHEST_SLIDE_M, FARTHEST_SLIDE_M), True
    if limited:
        ET.SubElement(joint, "limit", lower=repr(limits[0]), upper=repr(limits[1]), effort="0", velocity="0")


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
