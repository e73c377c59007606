"""The links of a URDF as rigid bodies for a physics engine, each on the one before it."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.mechanism import MimicJoint
from robolaser.robot.kinematics import Robot
from robolaser.robot.pinocchio_model import PinocchioModel
from robolaser.robot.urdf.checking import read_xml
from robolaser.robot.urdf.elements import origin_of

RADIUS_M = 0.05  # of the ball that replaces a body with impossible inertia


@final
@dataclass(frozen=True, eq=False)
class BodyJoint:
    """A joint of one degree of freedom."""

    name: str
    axis: Array  # unit axis in the body's frame, (3,)
    slides: bool
    limits: Array  # least and largest value, (2,) [rad or m]; infinite: none
    follows: MimicJoint | None  # None: it moves independently


@final
@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body."""

    name: str  # of its link
    parent: str | None  # the body that carries it; None: the root
    T: Array  # its placement on the parent, (4, 4)
    joint: BodyJoint | None  # its joint on its parent; None: it is fixed
    mass: float  # [kg]
    com: Array  # centre of mass in its own frame, (3,) [m]
    inertia: Array  # about the centre of mass, along its own axes, (3, 3) [kg m²]


def bodies(text: str, robot: Robot) -> Iterator[RigidBody]:
    """Each link of a URDF after the one that carries it.

    Joints that the robot does not read follow others, or are fixed at neutral.
    """
    arm = Robot.from_urdf(text, flange=robot.flange, joints=robot.joints).by_pinocchio
    inertials = {link.get("name"): link.find("inertial") for link in read_xml(text).findall("link")}
    for link in arm.links:
        mass, com, inertia = _inertial(inertials[link.name])
        joint = None if link.joint is None else _joint(arm, link.joint)
        yield RigidBody(link.name, link.parent or None, link.T_parent_link, joint, mass, com, inertia)


def _joint(arm: PinocchioModel, number: int) -> BodyJoint:
    follows = None
    if number not in arm.columns:
        leader = int(np.abs(arm.ratios[number]).argmax())
        other, ratio = arm.moving[arm.columns[leader]], float(arm.ratios[number, leader])
        follows = MimicJoint(arm.moving[number], other, ratio, float(arm.offsets[number]))
    limits = np.array([limit[number] for limit in arm.limits])
    return BodyJoint(arm.moving[number], arm.axes[number], bool(arm.slides[number]), limits, follows)


def _inertial(inertial: ET.Element | None) -> tuple[float, Array, Array]:
    """Mass, centre and inertia as described, if a body can have it; else a ball's."""
    if inertial is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    mass, T = float(inertial.find("mass").get("value", "0")), origin_of(inertial, "a body", "the URDF")  # type: ignore[union-attr]
    ball, stated = 0.4 * mass * RADIUS_M**2 * np.eye(3), inertial.find("inertia")
    if stated is None:
        return mass, T[:3, 3], ball
    xx, yy, zz, xy, xz, yz = (float(stated.get(key, "0")) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
    inertia: Array = T[:3, :3] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ T[:3, :3].T
    least, middle, most = np.linalg.eigvalsh(inertia)
    return mass, T[:3, 3], inertia if least > 0.0 and most < least + middle else ball
