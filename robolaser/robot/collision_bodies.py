"""Rigid bodies of a robot's links and its surroundings: boxes, spheres, cylinders and capsules."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import pose, rotation_to_axis
from robolaser.robot.kinematics import Robot
from robolaser.robot.pinocchio_model import Link, PinocchioModel
from robolaser.robot.urdf.checking import read_xml
from robolaser.robot.urdf.elements import numbers, origin_of

SHARE_OF_ARM = 0.028  # of its length: radius of a link without geometry; a UR5e has 0.03 to 0.04, a SCORBOT 0.03
LEAST_RADIUS_M, MOST_RADIUS_M = 0.004, 0.06
USUAL_ARM_M = 0.6
SIZES = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}}
"""Attributes of each shape that a URDF draws, and how many numbers each has."""


@final
@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body on a link."""

    name: str  # for people
    link: str  # the link that carries it
    kind: str  # "box", "sphere", "cylinder" or "capsule"; round ones have their axis along z
    # a box's edges (x, y, z), a sphere's (radius,), of the others (radius, length); a capsule's caps come on top of
    # its length [m]
    size: tuple[float, ...]
    T_link_body: Array  # its centre, (4, 4)


def arm_length(robot: Robot | None) -> float:
    """Sum of the distances between successive joints [m]; a usual one where there is no robot."""
    if robot is None:
        return USUAL_ARM_M
    steps = [robot.placements[i, :3, 3] for i in robot.chain] + [robot.end[:3, 3]]
    return float(sum(np.linalg.norm(step) for step in steps)) or USUAL_ARM_M


def link_radius(robot: Robot | None) -> float:
    """Radius of links without geometry [m]."""
    return float(np.clip(SHARE_OF_ARM * arm_length(robot), LEAST_RADIUS_M, MOST_RADIUS_M))


def link_bodies(robot: Robot, radius_m: float | None = None) -> tuple[Body, ...]:
    """The bodies of a robot's links.

    A link has the boxes, spheres and cylinders of its `<collision>` elements. If it has none, or meshes, which are not
    read, it is represented by capsules: from its own joint straight to the axis of each joint that it carries, and
    along that to the joint's origin, which may be anywhere on its axis. Their radius is a share of the arm's length
    unless given.
    """
    arm, drawn = robot.by_pinocchio, _drawn(robot.urdf)
    radius = link_radius(robot) if radius_m is None else radius_m
    bodies = []
    for link in robot.links:
        bodies += [Body(link, link, kind, size, T) for kind, size, T in drawn.get(link, ())]
        if link not in drawn:
            corners = [_to_joint(arm, child) for child in arm.links if child.parent == link]
            lines = [line for points in corners for line in pairwise(points) if np.ptp(line, axis=0).max() > radius / 2]
            bodies += capsules(link, link, lines, radius)
    return tuple(bodies)


def capsules(name: str, link: str, lines: Sequence[tuple[Array, Array]], radius: float) -> list[Body]:
    """A capsule about each straight line between two points (3,) of a link."""
    found = []
    for start, end in lines:
        length = float(np.linalg.norm(end - start))
        R = rotation_to_axis((end - start) / length) if length else np.eye(3)
        found.append(Body(name, link, "capsule", (radius, length), pose(R, (start + end) / 2)))
    return found


def carried_bodies(name: str, robot: Robot, points: Array, radius: float) -> list[Body]:
    """Capsules from the flange to the first of some points in its frame, (k, 3) [m], and on to the others."""
    return capsules(name, robot.flange, [*pairwise([np.zeros(3), *points])], radius)


def _to_joint(arm: PinocchioModel, child: Link) -> list[Array]:
    """Corners of the path from a link's origin to the joint of a link that it carries, (3,) [m] each."""
    end = child.T_parent_link[:3, 3]
    axis = np.zeros(3) if child.joint is None else child.T_parent_link[:3, :3] @ arm.axes[child.joint]
    return [np.zeros(3), end - (end @ axis) * axis, end]


def _drawn(text: str) -> dict[str, list[tuple[str, tuple[float, ...], Array]]]:
    """Kind, size and placement on its link of each shape that a URDF draws for collisions.

    Links with a mesh or with a shape of unreadable size are omitted: their other shapes are only a part of them.
    """
    drawn = {}
    for link in read_xml(text).findall("link"):
        try:
            shapes = [_shape(element) for element in link.findall("collision")]
        except RobotError:
            continue
        if shapes:
            drawn[link.get("name", "")] = shapes
    return drawn


def _shape(element: ET.Element) -> tuple[str, tuple[float, ...], Array]:
    geometry = element.find("geometry/*")
    kind = "" if geometry is None else geometry.tag
    if geometry is None or kind not in SIZES:
        raise RobotError(f"<{kind}> is no simple shape.")
    size = np.concatenate([numbers(geometry.get(key), n, key, "the URDF") for key, n in SIZES[kind].items()])
    if (size <= 0).any():
        raise RobotError(f"A {kind} of no size.")
    return kind, tuple(size.tolist()), origin_of(element, "collision", "the URDF")
