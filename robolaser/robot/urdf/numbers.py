"""Numbers in the attributes of a URDF: finite, of a size that a robot has, and as many as there should be."""

import re
import xml.etree.ElementTree as ET

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import pose, rot_x, rot_y, rot_z

MOST_LETTERS = 200  # of a number
FARTHEST = 1e6  # m or rad: beyond it a number is a slip, and sums of such numbers lose the micrometres

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def numbers(text: str | None, count: int, where: str, source: str, farthest: float = FARTHEST) -> Array:
    """So many finite numbers in the text of an attribute, (count,).

    Raises:
        RobotError: They are fewer or more, or beyond what a robot has.
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
