"""An arm as a table of Denavit and Hartenberg's four numbers a joint, written as a URDF."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, final

from robolaser.errors import RobotError
from robolaser.robot.by_name.description import rows_urdf

Convention = Literal["standard", "modified"]
CONVENTIONS: tuple[Convention, ...] = ("standard", "modified")
FLANGE = "flange"
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
    return rows_urdf([_numbers(row) for row in rows], convention, name, "base", FLANGE, first=1)


def _numbers(row: DHRow) -> dict[str, Any]:
    """As `rows_urdf` has it."""
    numbers: dict[str, Any] = {"a_m": row.a, "alpha_rad": row.alpha, "d_m": row.d, "theta_rad": row.theta}
    if row.kind == "fixed":
        return numbers
    unit = "m" if row.kind == "prismatic" else "rad"
    numbers |= {"joint": row.name, "slides": row.kind == "prismatic", "mass_kg": row.mass, "com_m": row.com}
    return numbers | {f"lower_{unit}": row.lower, f"upper_{unit}": row.upper}


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
