"""Rows of numbers, of Denavit and Hartenberg or of frames, written as a URDF."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import apply, pose, rot_x, rot_y, rot_z
from robolaser.geometry.units import ANGLE, FACTORS, LENGTH
from robolaser.robot.urdf.elements import add_fixed, add_link, add_moving

Convention = Literal["standard", "modified", "frames"]
SI = {unit: factor for quantity in (LENGTH, ANGLE) for unit, factor in FACTORS[quantity].items()} | {"kg": 1.0}
ZERO, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def rows_urdf(
    rows: Sequence[Mapping[str, Any]], convention: Convention, name: str, base: str, flange: str, *, first: int = 0
) -> str:
    """Write rows, from the base to the flange, as a URDF.

    A row has a joint (`joint`, its name; `slides`, if it does; its limits `lower_deg` and `upper_deg`, or in m, or
    none; `mass_kg` and `com_m`, the centre of mass, of the link that it moves), or is a fixed step. The link of row i
    is `link_i`, counted from `first`. Its placement on the row before is given by

    - `a_m`, `alpha_deg`, `d_m` and `theta_deg` of Denavit and Hartenberg, "standard" or "modified" (Craig's), with
      `com_m` in the row's own frame, which they lead to;
    - or, as "frames", `xyz_m` and `rpy_deg`, and in that frame the joint's `axis` and `com_m`.

    Omitted numbers are zero, and an omitted axis is z.
    """
    robot = ET.Element("robot", name=name)
    add_link(robot, base)
    link, T = base, np.eye(4)
    for number, row in enumerate(map(_in_si, rows), first):
        before, after = _steps(row, convention)
        T = T @ before
        if "joint" in row:
            child, limits = f"link_{number}", (float(row.get("lower", -np.inf)), float(row.get("upper", np.inf)))
            add_link(robot, child, float(row["mass"]), apply(after, np.array(row.get("com", ZERO))))
            axis, slides = np.array(row.get("axis", Z)), bool(row.get("slides", False))
            add_moving(robot, row["joint"], link, child, T, axis, limits, slides=slides)
            link, T = child, np.eye(4)
        T = T @ after
    add_link(robot, flange)
    add_fixed(robot, f"{flange}_joint", link, flange, T)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def _steps(row: Mapping[str, Any], convention: Convention) -> tuple[Array, Array]:
    """The placements before and behind a row's joint, two (4, 4)."""
    if convention == "frames":
        roll, pitch, yaw = np.array(row.get("rpy", ZERO))
        return pose(rot_z(yaw) @ rot_y(pitch) @ rot_x(roll), np.array(row.get("xyz", ZERO))), np.eye(4)
    a, alpha, d, theta = (np.array(row.get(key, 0.0)) for key in ("a", "alpha", "d", "theta"))
    about_x, about_z = pose(rot_x(alpha), np.array([a, 0.0, 0.0])), pose(rot_z(theta), np.array([0.0, 0.0, d]))
    return (about_z, about_x) if convention == "standard" else (about_x @ about_z, np.eye(4))


def _in_si(row: Mapping[str, Any]) -> dict[str, Any]:
    """The row in m, rad and kg, by keys without their units."""
    found = {key: row[key] for key in ("joint", "axis", "slides") if key in row}
    for key in row.keys() - found.keys():
        bare, _, unit = key.rpartition("_")
        found[bare] = SI[unit] * np.array(row[key], dtype=float)
    return found
