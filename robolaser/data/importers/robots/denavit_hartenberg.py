"""An arm as a table of Denavit and Hartenberg's four numbers a joint, written as a URDF."""

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import apply, pose, rot_x, rot_z
from robolaser.geometry.urdf.elements import add_fixed, add_link, add_moving

Convention = Literal["standard", "modified"]
CONVENTIONS: tuple[Convention, ...] = ("standard", "modified")
FLANGE = "flange"
Z = np.array([0.0, 0.0, 1.0])
JOINT_KINDS = ("revolute", "prismatic", "fixed")


@final
@dataclass(frozen=True)
class DHRow:
    """One row of the table; a fixed one has no joint, as a row of a tool or a base."""

    name: str  # of the joint
    a: float  # length of the common normal [m]
    alpha: float  # twist about it [rad]
    d: float  # offset along the joint's axis [m]; of a prismatic joint where its reading is zero
    theta: float  # angle about that axis where the joint's reading is zero [rad]
    kind: str = "revolute"  # "revolute", "prismatic" or "fixed"
    lower: float = -math.inf  # least reading [rad] or [m]; -inf: no limit
    upper: float = math.inf  # largest reading
    mass: float = 0.0  # of the link that the joint moves [kg]; 0: not known
    # its centre of mass in the row's own frame, the one that the four numbers lead to [m]
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)


def dh_urdf(rows: Sequence[DHRow], convention: Convention, name: str = "arm") -> str:
    r"""Write a table as a URDF with the links `base`, `link_1` and so on, and `flange`.

    Args:
        rows: From the base to the flange.
        convention: "standard": a row is :math:`R_z(\theta) T_z(d) T_x(a) R_x(\alpha)` (Denavit, Hartenberg 1955);
            "modified": :math:`R_x(\alpha) T_x(a) R_z(\theta) T_z(d)`, a and alpha of the axis before it (Craig).
        name: Of the robot.

    Raises:
        RobotError: There is no moving joint, two share a name, a prismatic one has no limits, lower is above upper, or
            a fixed row has a mass.
    """
    _check(rows, name)
    robot = ET.Element("robot", name=name)
    add_link(robot, "base")
    link, T = "base", np.eye(4)
    for number, row in enumerate(rows, 1):
        about_x = pose(rot_x(np.array(row.alpha)), np.array([row.a, 0.0, 0.0]))
        about_z = pose(rot_z(np.array(row.theta)), np.array([0.0, 0.0, row.d]))
        before, after = (about_z, about_x) if convention == "standard" else (about_x @ about_z, np.eye(4))
        T = T @ before
        if row.kind != "fixed":
            child, slides = f"link_{number}", row.kind == "prismatic"
            add_link(robot, child, row.mass, apply(after, np.array(row.com)))
            add_moving(robot, row.name, link, child, T, Z, (row.lower, row.upper), slides=slides)
            link, T = child, np.eye(4)
        T = T @ after
    add_link(robot, FLANGE)
    add_fixed(robot, f"{FLANGE}_joint", link, FLANGE, T)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def _check(rows: Sequence[DHRow], name: str) -> None:
    joints = [row.name for row in rows if row.kind != "fixed"]
    if not joints:
        raise RobotError(f"{name}: the table has no joint that moves.")
    twice = [joint for joint in joints if joints.count(joint) > 1]
    if twice:
        raise RobotError(f"{name}: two joints are named '{twice[0]}'. Rename one.")
    for row in rows:
        if row.lower > row.upper:
            raise RobotError(
                f"{name}: joint '{row.name}' has its lower limit {row.lower:g} above its upper {row.upper:g}."
            )
        if row.kind == "fixed" and row.mass > 0:
            raise RobotError(
                f"{name}: row '{row.name}' is fixed and has a mass. Add it to the link of the joint before."
            )
        if row.kind == "prismatic" and not (math.isfinite(row.lower) and math.isfinite(row.upper)):
            raise RobotError(f"{name}: joint '{row.name}' slides without limits. State its lower and upper limit.")
