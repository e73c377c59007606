"""The links of a URDF as rigid bodies for a physics engine, each on the one before it."""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.urdf.parsing import origin_of, parse, read_xml
from robolaser.geometry.urdf.tree import Joint

RADIUS_M = 0.05  # of the ball that stands for a body whose inertia no body can have


@final
@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body."""

    name: str  # of its link
    parent: str | None  # the body that carries it; None: the root
    T: Array  # its placement on the parent, (4, 4)
    joint: Joint | None  # what moves it on its parent; None: nothing does
    mass: float  # [kg]
    com: Array  # centre of mass in its own frame, (3,) [m]
    inertia: Array  # about the centre of mass, along its own axes, (3, 3) [kg m²]


def bodies(text: str, moving: Collection[str]) -> Iterator[RigidBody]:
    """Each link of a URDF after the one that carries it; joints that are not listed are held at neutral."""
    tree = parse(text)
    described = {
        element.get("name"): element.find("inertial") for element in read_xml(text, tree.source).findall("link")
    }
    children: dict[str, list[Joint]] = {}
    for joint in tree.joints.values():
        children.setdefault(joint.parent, []).append(joint)
    waiting: list[tuple[str, Joint | None]] = [(tree.root, None)]
    while waiting:
        name, above = waiting.pop(0)
        waiting += [(joint.child, joint) for joint in children.get(name, [])]
        link = tree.links[name]
        yield RigidBody(
            name=name,
            parent=above.parent if above else None,
            T=above.origin if above else np.eye(4),
            joint=above if above and above.name in moving else None,
            mass=link.mass,
            com=link.com,
            inertia=_inertia(described[name], link.mass),
        )


def _inertia(inertial: ET.Element | None, mass: float) -> Array:
    """As described, if a body can have it; else that of a ball."""
    ball = 0.4 * max(mass, 0.0) * RADIUS_M**2 * np.eye(3)
    stated = None if inertial is None else inertial.find("inertia")
    if inertial is None or stated is None:
        return ball
    xx, yy, zz, xy, xz, yz = (float(stated.get(key, "0")) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
    R = origin_of(inertial, "a body", "robot.urdf")[:3, :3]
    inertia: Array = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    least, middle, most = np.linalg.eigvalsh(inertia)
    return inertia if least > 0.0 and most < least + middle else ball
