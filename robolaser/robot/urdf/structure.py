"""How the joints of a URDF hang together: one tree of links, and joints that follow others (mimic)."""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator, Mapping

from robolaser.errors import RobotError, near
from robolaser.robot.urdf.numbers import numbers

MOVING = ("revolute", "continuous", "prismatic")
MOST_LISTED = 12  # names of a robot's links or joints in a message
Follower = tuple[str, float, float]
"""The joint that one follows (mimics), and its value over that joint's, and where that one is at zero [rad or m]."""


def followers(joints: Mapping[str, ET.Element], source: str) -> Iterator[tuple[str, Follower]]:
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


def check_tree(links: Collection[str], joints: Mapping[str, ET.Element], source: str) -> None:
    """See that all links hang on one root.

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
