"""The failures of an arm that a recording distinguishes, and messages that several files share."""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import ArmError, DataError, LineLost
from robolaser.robot.kinematics import Robot


@final
class AnswerUnclear(ArmError):
    """A device answers, but not to the question."""


@final
class ArmAlarm(ArmError):
    """The controller or a servo reports a fault."""


@final
class ArmRestarted(ArmError):
    """The controller has restarted."""


@final
class NotSettled(ArmError):
    """The arm does not stand still."""


def line_lost(port: str, reason: str) -> LineLost:
    """The error of a silent or lost line."""
    return LineLost(
        f"The line to the arm on {port} is lost: {reason}."
        " Check plug, power and that [arm] baud and flow in cell.toml are the controller's."
    )


def unclear(port: str, command: str, answer: str, tries: int) -> AnswerUnclear:
    """The error of a command whose answers cannot be understood."""
    return AnswerUnclear(
        f"The arm on {port} gave no valid answer to '{command}' in {tries} tries, the last one being"
        f" {answer[-60:]!r}. Check [arm] kind and baud in cell.toml, and the cable's shield."
    )


def refused(port: str, command: str, answer: str, meaning: str) -> ArmError:
    """The error of a command that was understood and rejected."""
    why = f": {meaning}" if meaning else ""
    return ArmError(f"The arm on {port} refused '{command}' with '{answer}'{why}. Resolve this before going on.")


def alarm(port: str, joint: str, message: str, advice: str) -> ArmAlarm:
    """The error of an arm that reports a fault."""
    return ArmAlarm(f"The arm on {port} reports '{message}' ({joint}). {advice}")


def not_settled(when: str, joint: str, moved: str) -> NotSettled:
    """The error of an arm that moves when it should rest."""
    return NotSettled(f"{when}, {joint} moved by {moved}. Wait until the arm rests, and let no other program move it.")


def joints_differ(kind: str, joints: int, most: int) -> DataError:
    """The error of a robot with more joints than its controller moves, or none at all."""
    return DataError(
        f"cell.toml, [arm] kind '{kind}' moves up to {most} joints, but dataset.toml, [robot] joints lists"
        f" {joints}. List the joints that this controller moves, base first.",
        file="dataset.toml",
        column="joints",
    )


def joint_text(robot: Robot, joint: int, value: float) -> str:
    """One joint's value, in degrees, or in millimetres for a rail."""
    return f"{1000 * value:.2f} mm" if robot.prismatic[joint] else f"{np.rad2deg(value):.2f}°"


def configuration_text(robot: Robot, q: Array) -> str:
    """All joints' values, (j,)."""
    return ", ".join(f"{joint} {joint_text(robot, i, float(q[i]))}" for i, joint in enumerate(robot.joints))


def at_worst(robot: Robot, off: Array, *postures: Array) -> tuple[str, ...]:
    """Name of the joint that is off the most, (j,), and its value in each of some postures, (j,) each."""
    joint = int(np.argmax(off))
    return robot.joints[joint], *(joint_text(robot, joint, float(q[joint])) for q in postures)
