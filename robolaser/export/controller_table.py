"""controller.csv: what to change in a controller, a number a row, in the words of those who service arms."""

import csv
import io
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.link_parameters import NUMBERS, link, link_parameters
from robolaser.geometry.rigid_motion import inverse
from robolaser.robot.kinematics import Robot

HEADER: Final = ("joint", "number", "nominal", "corrected", "correction", "unit", "meaning")
MEANING: Final = {
    "theta": "zero of the joint: the joint is at what the controller shows, plus the correction",
    "d": "distance along the joint's axis to the next common normal",
    "a": "length of the link: distance between this joint's axis and the next one",
    "alpha": "twist of the link: angle of the next axis, about x",
    "beta": "tilt of the next axis, about y, where the arm is built with parallel axes",
}
SHOWN: Final = {"theta": (np.degrees(1.0), "deg"), "d": (1e3, "mm"), "a": (1e3, "mm"),
                "alpha": (np.degrees(1.0), "deg"), "beta": (np.degrees(1.0), "deg")}  # fmt: skip
OF_BASE: Final = ("theta", "d")
"""Of the first joint these say where the base is, of the last one the others where the tool is: both are fitted."""
OF_TOOL: Final = ("a", "alpha", "beta")


def controller_table(calibration: Calibration) -> str | None:
    """The Denavit-Hartenberg numbers of the nominal and of the corrected arm, and each joint's zero in encoder steps.

    Degrees and millimetres: a person types them. None where nothing that a controller can hold was found, or one
    reading moves several joints.
    """
    robot, corrected = calibration.model.dataset.robot, calibration.robot
    if robot is None or corrected is None or corrected is robot or not has_links(robot):
        return None
    known = link_parameters(robot)
    nominal, (there, _) = known[0], link_parameters(corrected, known)
    step = calibration.model.dataset.noise.joint_step_rad
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(HEADER)
    for number, joint in enumerate(robot.chain):
        name, moved = robot.joints[joint], there[number] - nominal[number]
        absent = OF_BASE if number == 0 else OF_TOOL if number == len(nominal) - 1 else ()
        for i, what in enumerate(NUMBERS):
            if what in absent or (what == "beta" and not there[number, i]):
                continue
            scale, unit = SHOWN[what]
            change = _turn(moved[i]) if unit == "deg" else moved[i]
            values = (nominal[number, i], nominal[number, i] + change, change)
            table.writerow(
                [name, what, *(f"{round(scale * value, 6) + 0.0:.6f}" for value in values), unit, MEANING[what]]
            )
        if step and number and not robot.prismatic[joint]:
            ticks = _turn(moved[0]) / step
            table.writerow([name, "zero", "", "", f"{ticks:.1f}", "encoder steps", "correction of theta, in steps"])
    return out.getvalue()


def has_links(robot: Robot) -> bool:
    """Whether each joint of the chain follows a reading of its own: then a row of numbers describes it."""
    arm = robot.by_pinocchio
    own = np.zeros_like(arm.ratios)
    own[arm.columns, np.arange(len(arm.columns))] = 1.0
    return bool(np.array_equal(arm.ratios, own) and not arm.offsets.any())


def flange_by_table(text: str, robot: Robot, q: Array) -> Array:
    """T_base_flange by the corrected numbers of a controller.csv, (n, j) -> (n, 4, 4).

    Args:
        text: The file.
        robot: The nominal arm, which has the first joint's line in the base and the flange on the last one.
        q: Joint values.
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
        moved[:, NUMBERS.index("d" if robot.prismatic[joint] else "theta")] += q[:, joint]
        T = T @ link(moved)
    return np.asarray(T @ end)


def _turn(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
