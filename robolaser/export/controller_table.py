"""controller.csv: the corrections for a controller, a number a row, in the terms of service engineers.

The Denavit-Hartenberg parameters of an arm are computed from the axes of its joints.
Frame 1 is on the first joint's line. T_i,i+1 = Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta); a prismatic joint's q is
added to d. Where the nominal arm has two parallel lines, d is arbitrary: it is 0, and beta tilts the second line
(Hayati, Mirmirani 1985, J. Robotic Systems 2). The last row turns x towards the flange's and extends along the last
line to the flange's origin.
"""

import csv
import io
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.data.csv_tables import table_text
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose
from robolaser.robot.kinematics import Robot

PARALLEL: Final = np.radians(2.0)  # of neighbouring lines, below which they are built parallel. A judgement
COINCIDE: Final = 1e-6  # length of a link, below which it has none [m]. A judgement.
NUMBERS: Final = ("theta", "d", "a", "alpha", "beta")
HEADER: Final = ("joint", "number", "nominal", "corrected", "correction", "unit", "meaning")
MEANING: Final = {
    "theta": "angle about the joint's axis to the next common normal",
    "d": "distance along the joint's axis to the next common normal",
    "a": "length of the link: distance between this joint's axis and the next one",
    "alpha": "twist of the link: angle of the next axis, about x",
    "beta": "tilt of the next axis, about y, where the arm is built with parallel axes",
}
ZERO: Final = "zero of the joint: the joint is at what the controller shows, plus the correction"
SHOWN: Final = {"theta": (np.degrees(1.0), "deg"), "d": (1e3, "mm"), "a": (1e3, "mm"),
                "alpha": (np.degrees(1.0), "deg"), "beta": (np.degrees(1.0), "deg")}  # fmt: skip
OF_BASE: Final = ("theta", "d")
"""Of the first joint these locate the base, of the last one the others the tool: both are fitted."""
OF_TOOL: Final = ("a", "alpha", "beta")


def controller_table(calibration: Calibration) -> str | None:
    """The Denavit-Hartenberg numbers of the nominal and of the corrected arm, and each joint's zero in encoder steps.

    Degrees and millimetres, to be typed. None where nothing that a controller can hold was found, or one reading moves
    several joints.
    """
    robot, corrected = calibration.model.dataset.robot, calibration.robot
    if robot is None or corrected is None or corrected is robot or not has_links(robot):
        return None
    known = link_parameters(robot)
    nominal, (there, _) = known[0], link_parameters(corrected, known)
    step = calibration.model.dataset.noise.joint_step_rad
    rows = []
    for number, joint in enumerate(robot.chain):
        name, moved, own = robot.joints[joint], there[number] - nominal[number], _moving(robot, joint)
        absent = OF_BASE if number == 0 else OF_TOOL if number == len(nominal) - 1 else ()
        for i, what in enumerate(NUMBERS):
            if what in absent or (what == "beta" and not there[number, i]):
                continue
            scale, unit = SHOWN[what]
            change = _turn(moved[i]) if unit == "deg" else moved[i]
            values = (nominal[number, i], nominal[number, i] + change, change)
            shown = (f"{round(scale * value, 6) + 0.0:.6f}" for value in values)
            rows.append([name, what, *shown, unit, ZERO if what == own else MEANING[what]])
        if step and number and own == "theta":
            ticks = _turn(moved[0]) / step
            rows.append([name, "zero", "", "", f"{ticks:.1f}", "encoder steps", "correction of theta, in steps"])
    return table_text(HEADER, rows)


def has_links(robot: Robot) -> bool:
    """Whether each joint of the chain has its own reading: then a row of numbers describes it.

    Fingers, which carry no flange, may follow any joint.
    """
    arm = robot.by_pinocchio
    own, carries = np.zeros_like(arm.ratios), arm.way > 0
    own[arm.columns, np.arange(len(arm.columns))] = 1.0
    return bool(np.array_equal(arm.ratios[carries], own[carries]) and not arm.offsets[carries].any())


def flange_by_table(text: str, robot: Robot, q: Array) -> Array:
    """T_base_flange by the corrected numbers of a controller.csv, (n, j) -> (n, 4, 4).

    The first joint's line in the base, and the flange on the last one, are those of the nominal arm.
    """
    rows, first = link_parameters(robot)
    at_zero = first
    for row in rows:
        at_zero = at_zero @ link(row)
    end = inverse(at_zero) @ robot.forward(np.zeros(len(robot.joints)))
    numbers = {robot.joints[joint]: number for number, joint in enumerate(robot.chain)}
    for one in csv.DictReader(io.StringIO(text)):
        if one["number"] in NUMBERS:
            at = numbers[one["joint"]], NUMBERS.index(one["number"])
            rows[at] = float(one["corrected"]) / SHOWN[one["number"]][0]
    T = first
    for row, joint in zip(rows, robot.chain, strict=True):
        moved = np.tile(row, (len(q), 1))
        moved[:, NUMBERS.index(_moving(robot, joint))] += q[:, joint]
        T = T @ link(moved)
    return np.asarray(T @ end)


def _moving(robot: Robot, joint: int) -> str:
    """The number to which a joint's value is added."""
    return "d" if robot.prismatic[joint] else "theta"


def _turn(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def link_parameters(robot: Robot, like: tuple[Array, Array] | None = None) -> tuple[Array, Array]:
    """A row of `NUMBERS` for each joint of the chain, (j, 5) [rad, m], and T_base_1 at the arm's zero, (4, 4).

    Args:
        robot: The arm; each of its joints has its own reading.
        like: The same of a nearly equal arm for comparison: parallel lines and signs are as there.
    """
    at, z, flange = joint_lines(robot)
    rows = np.zeros((len(z), len(NUMBERS)))
    first = T = _on_line(at[0], z[0], None if like is None else like[1][:3, 0])
    for i in range(len(z) - 1):
        rows[i] = _to_line(T, at[i + 1], z[i + 1], None if like is None else like[0][i])
        if i == 0:  # the position of frame 1 along and about the first line belongs to the base
            first = T = T @ link(rows[0] * (1.0, 1.0, 0.0, 0.0, 0.0))
            rows[0, :2] = 0.0
        T = T @ link(rows[i])
    there = inverse(T) @ flange
    x = there[:3, 0] if np.hypot(*there[:2, 0]) > COINCIDE else there[:3, 1]
    rows[-1, :2] = np.arctan2(x[1], x[0]), there[2, 3]
    return rows, first


def link(rows: Array) -> Array:
    """The motions of rows of `NUMBERS`, (..., 5) -> (..., 4, 4)."""
    theta, d, a, alpha, beta = np.moveaxis(rows, -1, 0)
    none = np.zeros_like(theta)
    turned = exp_so3(np.stack([none, none, theta], axis=-1))
    tilted = exp_so3(np.stack([alpha, none, none], axis=-1)) @ exp_so3(np.stack([none, beta, none], axis=-1))
    reached = np.stack([a * turned[..., 0, 0], a * turned[..., 1, 0], d], axis=-1)
    return pose(turned @ tilted, reached)


def joint_lines(robot: Robot) -> tuple[Array, Array, Array]:
    """A point of each joint's line and the line's direction, (j, 3) each, and T_base_flange, all at the arm's zero."""
    zero = np.zeros(len(robot.joints))
    frames = robot.joint_frames(zero)
    z = (frames[:, :3, :3] @ robot.axes[list(robot.chain), :, None])[..., 0]
    return frames[:, :3, 3], z, robot.forward(zero)


def _on_line(at: Array, z: Array, near: Array | None) -> Array:
    """A frame on a line with a direction, its x axis near another one."""
    near = np.eye(3)[np.argmin(np.abs(z))] if near is None else near
    x = near - (near @ z) * z
    x /= np.linalg.norm(x)
    return pose(np.column_stack([x, np.cross(z, x), z]), at)


def _to_line(T: Array, at: Array, z: Array, like: Array | None) -> Array:
    """The row that leads from a frame on one line to the next line."""
    ahead, z = T[:3, :3].T @ (at - T[:3, 3]), T[:3, :3].T @ z
    sine = float(np.hypot(z[0], z[1]))
    parallel = abs(np.sin(like[3]) if like is not None else sine) < np.sin(PARALLEL)
    if parallel:
        reached, d = ahead - ahead[2] / z[2] * z, 0.0
        a = float(np.hypot(reached[0], reached[1]))
        theta = float(np.arctan2(reached[1], reached[0])) if a > COINCIDE else 0.0
    else:
        x, across = np.array([-z[1], z[0], 0.0]) / sine, np.array([z[0], z[1], 0.0]) / sine
        d, a = float(ahead[2] - (ahead @ across) / sine * z[2]), float(ahead @ x)
        theta = float(np.arctan2(x[1], x[0]))
    if like is None:
        backwards = a < -COINCIDE or (abs(a) <= COINCIDE and np.cos(theta) < 0.0)
    else:
        backwards = np.cos(theta - like[0]) < 0.0
    if backwards:
        theta, a = float(np.arctan2(-np.sin(theta), -np.cos(theta))), -a
    v = link(np.array([theta, 0.0, 0.0, 0.0, 0.0]))[:3, :3].T @ z
    alpha, beta = float(np.arctan2(-v[1], v[2])), float(np.arcsin(np.clip(v[0], -1.0, 1.0))) if parallel else 0.0
    return np.array([theta, d, a, alpha, beta])
