"""Checks of a URDF before Pinocchio reads it: a malformed one raises a clear error, never an abort."""

import math
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import ROBOT_BYTES
from robolaser.errors import RobotError, near
from robolaser.robot.urdf import markup
from robolaser.robot.urdf.elements import bad_numbers, digits, numbers
from robolaser.robot.urdf.markup import too_large

MOVING = ("revolute", "continuous", "prismatic")
MOST_LISTED = 12  # names of a robot's links or joints in a message
Mimic = tuple[str, float, float]
"""The joint that a joint follows (mimics), its value over the leader's, and at the leader's zero [rad or m]."""
KINDS = (*MOVING, "fixed", "floating", "planar")
MOST_LINKS = 2000
MOST_LETTERS = 200  # in a name
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def read_xml(text: str, source: str = "robot.urdf") -> ET.Element:
    """The XML of a URDF as its author wrote it, with unique names of links and joints.

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
    for kind in ("link", "joint"):
        _check_names(robot, kind, source)
    return robot


def for_pinocchio(text: str, source: str) -> tuple[ET.Element, dict[str, Mimic]]:
    """The parts of a URDF that Pinocchio needs, in canonical digits, and the joints that follow others.

    Kept are links with their inertias, and joints with their ends, origin, axis and limits, whose effort and velocity
    are zero; visuals, collisions, meshes, transmissions and comments are not.

    Raises:
        RobotError: With the location and what was expected.
    """
    robot = read_xml(text, source)
    robot.set("name", robot.get("name") or "robot")
    robot[:] = [element for element in robot if element.tag in ("link", "joint")]
    links = [link.get("name", "") for link in robot.findall("link")]
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    for link in robot.findall("link"):
        _reduce_link(link, source)
    following = dict(_followers(joints, source))
    for name, joint in joints.items():
        _reduce_joint(joint, name, links, source)
    _check_tree(links, joints, source)
    return robot, following


def unknown_frame(source: str, frame: str, known: Iterable[str]) -> RobotError:
    """The error of a frame that the robot does not have."""
    return RobotError(f"No frame '{frame}' in {source}.{near(frame, known, MOST_LISTED)}")


def joint_kind(source: str, joint: str, kind: str | None, usable: Sequence[str]) -> RobotError:
    """The error of a joint of an unusable type."""
    problem = "has no type" if kind is None else f"is of type '{kind[:60]}'"
    return RobotError(f"{source}: joint '{joint}' {problem}; usable here: {', '.join(usable)}.")


def _check_names(robot: ET.Element, kind: str, source: str) -> None:
    elements = robot.findall(kind)
    if len(elements) > MOST_LINKS:
        raise too_large(source, f"{kind}s", MOST_LINKS)
    seen: set[str] = set()
    for count, element in enumerate(elements, start=1):
        name = element.get("name")
        if not name:
            raise _bad_name(source, kind, count, "has no name")
        if len(name) > MOST_LETTERS:
            raise _bad_name(source, kind, count, f"has a name of {len(name)} letters")
        if not name.isprintable() or (kind, name) == ("joint", "universe"):  # Pinocchio's name of its root
            raise _bad_name(source, kind, count, f"is named {name!r}")
        if name in seen:
            raise RobotError(f"{source} has two {kind}s named '{name}'. Rename one.")
        seen.add(name)


def _bad_name(source: str, kind: str, count: int, reason: str) -> RobotError:
    return RobotError(f"{source}: {kind} number {count} {reason}. Each {kind} needs a short name of its own.")


def _keep(element: ET.Element, *tags: str) -> None:
    """Drop all children but the first of each of these tags."""
    element[:] = [child for child in map(element.find, tags) if child is not None]


def _reduce_link(link: ET.Element, source: str) -> None:
    where, inertial = f"link '{link.get('name')}'", link.find("inertial")
    _keep(link, "inertial")
    if inertial is None:
        return
    mass = inertial.find("mass")
    text = None if mass is None else mass.get("value")
    if numbers(text, 1, f"the mass of {where}", source)[0] < 0:
        raise bad_numbers(source, f"the mass of {where}", text, "zero or more [kg]")
    inertia = inertial.find("inertia")
    inertia = ET.SubElement(inertial, "inertia") if inertia is None else inertia
    for key in INERTIA:
        inertia.set(key, digits(numbers(inertia.get(key, "0"), 1, f"{key} of {where}", source)))
    _reduce_origin(inertial, f"{where}, inertial", source)
    _keep(inertial, "origin", "mass", "inertia")


def _reduce_joint(joint: ET.Element, name: str, links: Collection[str], source: str) -> None:
    kind, where = joint.get("type"), f"joint '{name}'"
    if kind not in KINDS:
        raise joint_kind(source, name, kind, KINDS)
    for role in ("parent", "child"):
        _check_end(joint, role, where, links, source)
    _reduce_origin(joint, where, source)
    axis, limit = joint.find("axis"), joint.find("limit")
    if kind in MOVING and axis is not None:
        axis.set("xyz", digits(_direction(axis.get("xyz"), where, source)))
    if kind in ("revolute", "prismatic"):
        if limit is None or not {"lower", "upper"} & limit.attrib.keys():
            raise _bad_limits(source, where, "has no limits")
        lower, upper = (
            float(numbers(limit.get(side, "0"), 1, f"the {side} limit of {where}", source, math.inf)[0])
            for side in ("lower", "upper")
        )
        if lower > upper:
            raise _bad_limits(source, where, f"has its lower limit {lower:g} above its upper limit {upper:g}")
        limit.attrib.update(lower=repr(lower), upper=repr(upper), effort="0", velocity="0")
    limited = ("limit",) if kind in ("revolute", "prismatic") else ()
    _keep(joint, "parent", "child", "origin", *(("axis",) if kind in MOVING else ()), *limited)


def _check_end(joint: ET.Element, role: str, where: str, links: Collection[str], source: str) -> None:
    end = joint.find(role)
    link = None if end is None else end.get("link")
    if link is None:
        raise RobotError(f"{source}: {where} has no <{role} link=...>.{near('', links, MOST_LISTED)}")
    if link not in links:
        raise RobotError(
            f"{source}: {where} has the {role} link '{link}', which is not there.{near(link, links, MOST_LISTED)}"
        )


def _direction(text: str | None, where: str, source: str) -> Array:
    stated = numbers(text, 3, f"the axis of {where}", source)
    largest = np.abs(stated).max()
    if largest < 1e-9:
        raise bad_numbers(source, f"the axis of {where}", text, "a direction, not zero")
    unit: Array = stated / largest
    return unit / np.linalg.norm(unit)


def _reduce_origin(element: ET.Element, where: str, source: str) -> None:
    origin = element.find("origin")
    if origin is not None:
        for key in ("xyz", "rpy"):
            origin.set(key, digits(numbers(origin.get(key, "0 0 0"), 3, f"the origin {key} of {where}", source)))


def _bad_limits(source: str, where: str, fact: str) -> RobotError:
    return RobotError(f"{source}: {where} {fact}. Give <limit lower=... upper=...> in rad or m.")


def _followers(joints: Mapping[str, ET.Element], source: str) -> Iterator[tuple[str, Mimic]]:
    """The joints that follow others.

    Raises:
        RobotError: One follows itself, or none that moves.
    """
    leaders: dict[str, str] = {}
    for name, joint in joints.items():
        mimic = joint.find("mimic")
        if mimic is None or joint.get("type") not in MOVING:
            continue
        leader, where = mimic.get("joint", ""), f"joint '{name}'"
        if leader not in joints or joints[leader].get("type") not in MOVING:
            moving = [other for other, one in joints.items() if one.get("type") in MOVING]
            raise RobotError(
                f"{source}: {where} follows '{leader[:60]}' (mimic), which is no moving joint."
                f"{near(leader, moving, MOST_LISTED)}"
            )
        leaders[name], trail = leader, {name}
        while leader in leaders:
            if leader in trail:
                raise RobotError(f"{source}: {where} follows itself (mimic). Let one of these joints follow none.")
            trail.add(leader)
            leader = leaders[leader]
        ratio, offset = (
            float(numbers(mimic.get(key, usual), 1, f"the {key} of {where} (mimic)", source)[0])
            for key, usual in (("multiplier", "1"), ("offset", "0"))
        )
        yield name, (leaders[name], ratio, offset)


def _check_tree(links: Collection[str], joints: Mapping[str, ET.Element], source: str) -> None:
    """Check that all links form a tree with one root.

    Raises:
        RobotError: There are several roots, or none, or a link has two parents.
    """
    above: dict[str, str] = {}
    by_child: dict[str, str] = {}
    for name, joint in joints.items():
        parent, child = (joint.find(role).get("link", "") for role in ("parent", "child"))  # type: ignore[union-attr]
        if child in by_child:
            raise _no_tree(source, f"link '{child}' is the child of two joints, '{by_child[child]}' and '{name}'")
        above[child], by_child[child] = parent, name
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
            here = above[here]
        grounded.update(trail)


def _no_tree(source: str, fact: str) -> RobotError:
    return RobotError(f"{source}: {fact}. The links of a URDF form one tree that starts at one root link.")
