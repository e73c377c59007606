"""Rigid bodies that stand for a robot's links and what is about them: boxes, spheres, cylinders and capsules."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import pose, rotation_to_axis
from robolaser.geometry.urdf.tree import Joint
from robolaser.robot.kinematics import Robot

SHARE_OF_ARM = 0.028
"""Radius of a link that has no geometry, as a share of the arm's length: a UR5e has 0.03 to 0.04, a SCORBOT 0.03."""
LEAST_RADIUS_M, MOST_RADIUS_M = 0.004, 0.06
USUAL_ARM_M = 0.6


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


def link_radius(robot: Robot) -> float:
    """Radius that links without geometry are given [m]."""
    return float(np.clip(SHARE_OF_ARM * arm_length(robot), LEAST_RADIUS_M, MOST_RADIUS_M))


def link_bodies(robot: Robot, radius_m: float | None = None) -> tuple[Body, ...]:
    """The bodies of a robot's links.

    A link has the boxes, spheres and cylinders of its `<collision>` elements. Where it has none, or meshes, which are
    not read, capsules stand for it: from its own joint straight to the axis of each joint that it carries, and along
    that to the joint's origin, which may lie anywhere on its axis.

    Args:
        robot: Any arm.
        radius_m: Of the capsules; by default a share of the arm's length.
    """
    tree = urdf.parse(robot.urdf)
    drawn = urdf.collision_shapes(robot.urdf)
    radius = link_radius(robot) if radius_m is None else radius_m
    bodies = []
    for link in tree.links:
        bodies += [Body(link, link, kind, size, T) for kind, size, T in drawn.get(link, ())]
        if link not in drawn:
            corners = [_to_joint(joint) for joint in tree.joints.values() if joint.parent == link]
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


def _to_joint(joint: Joint) -> list[Array]:
    """Corners of the way from a link's origin to the origin of a joint that it carries, (3,) [m] each."""
    end = joint.origin[:3, 3]
    axis = joint.origin[:3, :3] @ joint.axis if joint.moves else np.zeros(3)
    return [np.zeros(3), end - (end @ axis) * axis, end]
