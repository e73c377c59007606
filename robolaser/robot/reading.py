"""A URDF read as the model of an arm: the joints in use, those that follow them, and all others at neutral."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from robolaser.errors import RobotError, near
from robolaser.robot.pinocchio_model import PinocchioModel
from robolaser.robot.urdf.checking import MOST_LISTED, MOVING, Mimic, for_pinocchio, joint_kind, unknown_frame
from robolaser.robot.urdf.markup import too_large

MOST_JOINTS = 100  # that move: Pinocchio's memory grows with their cube


def only_end(text: str, source: str) -> str:
    """The only link that carries no other.

    Raises:
        RobotError: There are several, or the text is no robot.
    """
    robot, _ = for_pinocchio(text, source)
    parents = {element.get("link") for element in robot.iter("parent")}
    ends = [name for link in robot.findall("link") if (name := link.get("name", "")) not in parents]
    if len(ends) != 1:
        more = f", and {len(ends) - MOST_LISTED} more" if len(ends) > MOST_LISTED else ""
        raise RobotError(
            f"{source} has {len(ends)} ends: {', '.join(ends[:MOST_LISTED])}{more}. State which link is the flange."
        )
    return ends[0]


def read_arm(text: str, *, flange: str, joints: Sequence[str] | None, source: str) -> tuple[PinocchioModel, str]:
    """The arm of a URDF, and its name; arguments and errors as for `Robot.from_urdf`."""
    import pinocchio  # noqa: PLC0415 - loaded only for data sets with an arm that is computed

    robot, followers = for_pinocchio(text, source)
    whole = _built(robot, source)
    if not whole.existFrame(flange, pinocchio.BODY):
        bodies = [frame.name for frame in whole.frames if frame.type == pinocchio.BODY]
        raise unknown_frame(source, flange, bodies)
    freedoms = dict(zip(whole.names, whole.nvs, strict=True))
    above = whole.supports[whole.frames[whole.getFrameId(flange, pinocchio.BODY)].parentJoint]
    way = [whole.names[number] for number in list(above)[1:]]
    for name in way:
        if freedoms[name] != 1:
            raise joint_kind(source, name, "planar" if freedoms[name] == 3 else "floating", (*MOVING, "fixed"))
    moving = [name for name, freedom in freedoms.items() if freedom == 1]
    listed = [name for name in way if name not in followers] if joints is None else _listed(joints, moving, source)
    rules = {name: _rule(name, listed, followers) for name in moving}
    used = {name for name, (leader, _, offset) in rules.items() if leader in listed or offset}
    if len(used) > MOST_JOINTS:
        raise too_large(source, "moving joints in use", MOST_JOINTS)
    if not any(rules[name][0] in listed for name in way):
        raise RobotError(
            f"{source}: none of the listed joints moves the flange '{flange}'. Joints that do:"
            f" {', '.join(way) or 'none'}."
        )
    for joint in robot.findall("joint"):
        if joint.get("name") not in used:
            joint.set("type", "fixed")
    model = _built(robot, source)
    names = list(model.names)[1:]
    ratios, offsets = np.zeros((len(names), len(listed))), np.array([rules[name][2] for name in names])
    for number, name in enumerate(names):
        leader, ratio, _ = rules[name]
        if leader in listed:
            ratios[number, listed.index(leader)] = ratio
    return PinocchioModel(model, [names.index(name) for name in listed], ratios, offsets, flange), model.name


def _built(robot: ET.Element, source: str) -> Any:
    import pinocchio  # noqa: PLC0415

    try:
        return pinocchio.buildModelFromXML(ET.tostring(robot, encoding="unicode"))
    except ValueError as fault:
        raise RobotError(f"{source}: Pinocchio does not read it: {fault}") from None


def _listed(names: Sequence[str], moving: Sequence[str], source: str) -> list[str]:
    for i, name in enumerate(names):
        if name not in moving:
            raise RobotError(f"No moving joint '{name}' in {source}.{near(name, moving, MOST_LISTED)}")
        if name in names[:i]:
            raise RobotError(f"Joint '{name}' of {source} is listed twice. List each joint once.")
    return list(names)


def _rule(name: str, listed: Sequence[str], followers: Mapping[str, Mimic]) -> Mimic:
    """The leader at the end of a joint's mimic chain, the joint's value over the leader's, and at the leader's zero."""
    ratio, offset = 1.0, 0.0
    while name not in listed and name in followers:
        name, further, shift = followers[name]
        offset += ratio * shift
        ratio *= further
    return name, ratio, offset
