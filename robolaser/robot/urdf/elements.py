"""Elements of a URDF: their numbers read, links and joints written."""

import math
import re
import xml.etree.ElementTree as ET

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import pose, rot_x, rot_y, rot_z

FARTHEST_SLIDE_M = 1e5  # limit of a sliding joint without limits: a URDF demands some
MOST_LETTERS = 200  # of a number
FARTHEST = 1e6  # m or rad: beyond it a number is a mistake, and sums of such numbers lose the micrometres
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def add_link(robot: ET.Element, name: str, mass: float = 0.0, com: Array | None = None) -> None:
    """A link, with its mass [kg] at its centre of mass (3,) [m], if any."""
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
    """`<origin>` of a placement (4, 4), exact to the last bit."""
    return {"xyz": digits(T[:3, 3]), "rpy": digits(_rpy(T[:3, :3]))}


def _rpy(R: Array) -> Array:
    """Roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll); at the pole, where yaw is free, exact too."""
    yaw = np.arctan2(R[1, 0], R[0, 0])
    rest = rot_z(-yaw) @ R
    return np.array([np.arctan2(-rest[1, 2], rest[1, 1]), np.arctan2(-rest[2, 0], rest[0, 0]), yaw])


def digits(values: Array | float) -> str:
    """Numbers to the last bit."""
    return " ".join(repr(float(value)) for value in np.ravel(values))


def numbers(text: str | None, count: int, where: str, source: str, farthest: float = FARTHEST) -> Array:
    """So many finite numbers in the text of an attribute, (count,).

    Raises:
        RobotError: They are fewer or more, or too large for a robot.
    """
    words = [] if text is None else text.split()
    wanted = "a number" if count == 1 else f"{count} numbers"
    if len(words) != count or not all(len(word) < MOST_LETTERS and _NUMBER.fullmatch(word) for word in words):
        raise bad_numbers(source, where, text, wanted)
    values = np.array([float(word) for word in words])
    if not np.isfinite(values).all() or np.abs(values).max() > farthest:
        raise bad_numbers(source, where, text, f"{wanted} of a size that a robot has")
    return values


def origin_of(element: ET.Element, where: str, source: str) -> Array:
    """The placement that an element's `<origin>` states, (4, 4); the identity where it has none."""
    origin = element.find("origin")
    xyz, rpy = (
        numbers("0 0 0" if origin is None else origin.get(key, "0 0 0"), 3, f"the origin {key} of {where}", source)
        for key in ("xyz", "rpy")
    )
    return pose(rot_z(rpy[2]) @ rot_y(rpy[1]) @ rot_x(rpy[0]), xyz)


def bad_numbers(source: str, where: str, text: str | None, expected: str) -> RobotError:
    """The error of an attribute that is missing or not what was expected."""
    problem = "is missing" if text is None else f"is '{text[:60]}'"
    hint = " Expand the file with xacro first." if text and "${" in text else ""
    return RobotError(f"{source}: {where} {problem}; expected {expected}.{hint}")
