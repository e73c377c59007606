"""A robot's description as text (URDF): read with suspicion, checked whole.

Everything is validated in Python before any C++ sees it: a malformed URDF must end in a sentence,
never in an aborted process.
"""

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.errors import RobotError, near, unreadable
from robolaser.geometry.rigid_motion import pose, rot_x, rot_y, rot_z
from robolaser.geometry.urdf import markup
from robolaser.geometry.urdf.markup import too_large
from robolaser.geometry.urdf.tree import KINDS, MOST_LISTED, MOVING, Joint, Link, Tree

MOST_LINKS = 2000
MOST_JOINTS = 100  # that move: Pinocchio's memory grows with their cube
MOST_LETTERS = 200  # in a name or a number
REMEMBERED = 8  # robots: each export asks for the same ones
FARTHEST = 1e6  # m or rad: beyond it a number is a slip, and sums of such numbers lose the micrometres

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def load_text(path: Path) -> str:
    """Read a URDF file as text.

    Raises:
        DataError: It cannot be opened, has more bytes than any robot, or is not UTF-8.
    """
    try:
        return read_text(path, ROBOT_BYTES)
    except ValueError as fault:  # a name with a zero byte
        raise unreadable(path, str(fault)) from None


@lru_cache(maxsize=REMEMBERED)
def parse(text: str, *, source: str = "robot.urdf") -> Tree:
    """Read and check a URDF; visuals, collisions, meshes and transmissions are passed over. The last ones are kept.

    Args:
        text: The URDF itself.
        source: What error messages call it.

    Raises:
        RobotError: With the place and what was expected.
    """
    robot = read_xml(text, source)
    links: dict[str, Link] = {}
    for name, element in _named(robot, "link", source):
        links[name] = _link(name, element, source)
    joints: dict[str, Joint] = {}
    for name, element in _named(robot, "joint", source):
        joints[name] = _joint(name, element, links, source)
    above = _above(joints, source)
    root = _root(links, above, source)
    return Tree(robot.get("name") or "robot", source, root, links, joints, above)


def read_xml(text: str, source: str) -> ET.Element:
    """The XML of a URDF, refused where it could harm.

    Raises:
        RobotError: It is not plain XML, or not a URDF.
    """
    robot = markup.read(text, source, ROBOT_BYTES)
    if robot.tag != "robot":
        raise RobotError(
            f"{source} starts with <{robot.tag[:60]}>, but a URDF starts with <robot>. Is it the right file?"
        )
    for element in robot.iter():
        if isinstance(element.tag, str) and element.tag.startswith("xacro:"):
            raise RobotError(
                f"{source} holds <{element.tag}>: it is a xacro file. Expand it first: xacro {source} > robot.urdf"
            )
    return robot


def _named(robot: ET.Element, kind: str, source: str) -> Iterator[tuple[str, ET.Element]]:
    elements = robot.findall(kind)
    if len(elements) > MOST_LINKS:
        raise too_large(source, f"{kind}s", MOST_LINKS)
    seen: set[str] = set()
    for count, element in enumerate(elements, start=1):
        name = element.get("name")
        if not name:
            raise _unnamed(source, kind, count, "has no name")
        if len(name) > MOST_LETTERS:
            raise _unnamed(source, kind, count, f"has a name of {len(name)} letters")
        if name in seen:
            raise RobotError(f"{source} has two {kind}s named '{name}'. Rename one.")
        seen.add(name)
        yield name, element


def _unnamed(source: str, kind: str, count: int, reason: str) -> RobotError:
    return RobotError(f"{source}: {kind} number {count} {reason}. Each {kind} needs a short name of its own.")


def _link(name: str, element: ET.Element, source: str) -> Link:
    inertial = element.find("inertial")
    if inertial is None:
        return Link(name, 0.0, np.zeros(3))
    mass_element, inertia = inertial.find("mass"), inertial.find("inertia")
    text = None if mass_element is None else mass_element.get("value")
    mass = float(numbers(text, 1, f"the mass of link '{name}'", source)[0])
    if mass < 0:
        raise _bad_numbers(source, f"the mass of link '{name}'", text, "zero or more [kg]")
    if inertia is not None:
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            numbers(inertia.get(key, "0"), 1, f"{key} of link '{name}'", source)
    return Link(name, mass, origin_of(inertial, f"link '{name}', inertial", source)[:3, 3])


def _joint(name: str, element: ET.Element, links: Mapping[str, Link], source: str) -> Joint:
    kind = element.get("type")
    if kind not in KINDS:
        raise joint_kind(source, name, kind, KINDS)
    where = f"joint '{name}'"
    follows = element.find("mimic")
    lower, upper = _limits(name, kind, element, source)
    return Joint(
        name=name,
        kind=kind,
        parent=_end(name, "parent", element, links, source),
        child=_end(name, "child", element, links, source),
        origin=origin_of(element, where, source),
        axis=_axis(element, where, source) if kind in MOVING else np.array([1.0, 0.0, 0.0]),
        lower=lower,
        upper=upper,
        follows=None if follows is None else follows.get("joint"),
    )


def _end(name: str, role: str, element: ET.Element, links: Mapping[str, Link], source: str) -> str:
    end = element.find(role)
    link = None if end is None else end.get("link")
    if link is None or link not in links:
        problem = f"has no <{role} link=...>." if link is None else f"has the {role} link '{link}', which is not there."
        raise RobotError(f"{source}: joint '{name}' {problem}{near(link or '', links, MOST_LISTED)}")
    return link


def _limits(name: str, kind: str, element: ET.Element, source: str) -> tuple[float, float]:
    if kind == "continuous" or kind not in MOVING:
        return -math.inf, math.inf
    limit = element.find("limit")
    if limit is None or not {"lower", "upper"} & limit.attrib.keys():
        raise _limits_missing(source, name, "has no limits")
    lower, upper = (
        float(numbers(limit.get(side, "0"), 1, f"the {side} limit of joint '{name}'", source, math.inf)[0])
        for side in ("lower", "upper")
    )
    if lower > upper:
        raise _limits_missing(source, name, f"has its lower limit {lower:g} above its upper limit {upper:g}")
    return lower, upper


def _limits_missing(source: str, joint: str, fact: str) -> RobotError:
    return RobotError(f"{source}: joint '{joint}' {fact}. Give <limit lower=... upper=...> in rad or m.")


def joint_kind(source: str, joint: str, kind: str | None, usable: Sequence[str]) -> RobotError:
    """The error of a joint of a kind that cannot be used there."""
    problem = "has no type" if kind is None else f"is of type '{kind[:60]}'"
    return RobotError(f"{source}: joint '{joint}' {problem}; usable here: {', '.join(usable)}.")


def _axis(element: ET.Element, where: str, source: str) -> Array:
    axis = element.find("axis")
    if axis is None:
        return np.array([1.0, 0.0, 0.0])
    text = axis.get("xyz")
    direction = numbers(text, 3, f"the axis of {where}", source)
    largest = np.abs(direction).max()
    if largest < 1e-9:
        raise _bad_numbers(source, f"the axis of {where}", text, "a direction, not zero")
    unit: Array = direction / largest
    return unit / np.linalg.norm(unit)


def origin_of(element: ET.Element, where: str, source: str) -> Array:
    """The placement that an element's `<origin>` says, (4, 4); the identity where it has none."""
    origin = element.find("origin")
    attributes = {} if origin is None else origin.attrib
    xyz = numbers(attributes.get("xyz", "0 0 0"), 3, f"the origin xyz of {where}", source)
    rpy = numbers(attributes.get("rpy", "0 0 0"), 3, f"the origin rpy of {where}", source)
    R = rot_z(rpy[2]) @ rot_y(rpy[1]) @ rot_x(rpy[0])
    return pose(R, xyz)


def numbers(text: str | None, count: int, where: str, source: str, farthest: float = FARTHEST) -> Array:
    """So many finite numbers in the text of an attribute, (count,).

    Raises:
        RobotError: They are fewer or more, or beyond what a robot has.
    """
    words = [] if text is None else text.split()
    wanted = "a number" if count == 1 else f"{count} numbers"
    if len(words) != count or not all(len(word) < MOST_LETTERS and _NUMBER.fullmatch(word) for word in words):
        raise _bad_numbers(source, where, text, wanted)
    values = np.array([float(word) for word in words])
    if not np.isfinite(values).all() or np.abs(values).max() > farthest:
        raise _bad_numbers(source, where, text, f"{wanted} of a size that a robot has")
    return values


def _bad_numbers(source: str, where: str, text: str | None, expected: str) -> RobotError:
    problem = "is missing" if text is None else f"is '{text[:60]}'"
    hint = " Expand the file with xacro first." if text and "${" in text else ""
    return RobotError(f"{source}: {where} {problem}; expected {expected}.{hint}")


def _above(joints: Mapping[str, Joint], source: str) -> dict[str, Joint]:
    above: dict[str, Joint] = {}
    for joint in joints.values():
        other = above.setdefault(joint.child, joint)
        if other is not joint:
            raise _no_tree(
                source, f"link '{joint.child}' is the child of two joints, '{other.name}' and '{joint.name}'"
            )
    return above


def _no_tree(source: str, fact: str) -> RobotError:
    return RobotError(f"{source}: {fact}. The links of a URDF form one tree that starts at one root link.")


def _root(links: Mapping[str, Link], above: Mapping[str, Joint], source: str) -> str:
    roots = [link for link in links if link not in above]
    if not links:
        raise _no_tree(source, "there is no link")
    if len(roots) > 1:
        named = ", ".join(f"'{root}'" for root in roots[:5]) + (", ..." if len(roots) > 5 else "")
        raise _no_tree(source, f"{len(roots)} links are the child of no joint: {named}")
    grounded = set(roots)
    for link in links:
        trail: dict[str, None] = {}
        here = link
        while here not in grounded:
            if here in trail:
                raise _no_tree(source, f"the joints above link '{here}' form a loop")
            trail[here] = None
            here = above[here].parent
        grounded.update(trail)
    return roots[0]
