"""A result's numbers written into a copy of a user's file: URDF, MJCF, LeRobot's calibration file."""

import json
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import ROBOT_BYTES
from robolaser.data.lerobot import TURN, read_servos
from robolaser.errors import DataError, RobotError
from robolaser.model.effects import EFFECTS
from robolaser.robot.urdf import markup
from robolaser.robot.urdf.checking import read_xml
from robolaser.robot.urdf.editing import with_placements
from robolaser.robot.urdf.elements import digits, origin_of
from robolaser.robot.urdf.elements import numbers as numbers_of

FARTHEST_M, FARTHEST_RAD = 0.05, 0.3  # that a joint of one robot is off at most: more, and the files describe two
OF_PLACEMENTS: Final = frozenset(effect.name for effect in EFFECTS if effect.in_urdf)
MOST: Final = 2047  # of a homing_offset, which has eleven bits and a sign [ticks]
Pair = tuple[str, str]  # an effect's name and its location


@final
@dataclass(frozen=True)
class Written:
    """A robot's file with a result in it."""

    text: str
    contains: tuple[Pair, ...]
    lacks: tuple[Pair, ...]
    remarks: tuple[str, ...] = ()  # the changes, for the user


@final
@dataclass(frozen=True)
class _Numbers:
    """The numbers of the effects at the joints of a moving arm, looked up by effect."""

    at: Mapping[Pair, Mapping[str, float]]
    used: set[Pair] = field(default_factory=set)

    def take(self, effect: str, joint: str, name: str, *, above: float = -math.inf) -> float | None:
        """A number that is above another one, and then counts as written."""
        found = self.at.get((effect, joint), {}).get(name)
        if found is None or found <= above:
            return None
        self.used.add((effect, joint))
        return found

    def attributes(self, joint: str, known: Mapping[str, Pair]) -> dict[str, str]:
        """The attributes with an effect's number each, where there is one."""
        found = {name: self.take(effect, joint, number) for name, (effect, number) in known.items()}
        return {name: digits(value) for name, value in found.items() if value is not None}


def motion_into(text: str, effects: Sequence[Mapping[str, Any]], source: str) -> Written:
    """Write the effects of a moving arm, as in diagnosis.json or calibration.json, into the text of its model.

    A URDF takes friction (`<dynamics>`). An MJCF takes damping, frictionloss and armature of joints, and delay, gains
    and range of their position actuators. A dead zone in a loop of stiffness kp acts as a dry friction of kp times its
    half width, and is written as that.

    Raises:
        RobotError: It is neither URDF nor MJCF, has none of the joints, or text where an actuator's number should be.
    """
    root = markup.read(text, source, ROBOT_BYTES)
    numbers = _Numbers(
        {
            (one["effect"], one["where"]): {name: each["value"] for name, each in one["parameters"].items()}
            for one in effects
        }
    )
    writers: dict[str, Callable[[ET.Element, _Numbers, set[str]], set[str]]] = {
        "robot": _urdf,
        "mujoco": partial(_mjcf, source=source),
    }
    if root.tag not in writers:
        raise RobotError(
            f"{source} starts with <{str(root.tag)[:60]}>: expected a URDF, <robot>, or an MJCF, <mujoco>."
        )
    joints = {where for _, where in numbers.at} - {"tool", "timing", "joints", "base"}
    there = writers[root.tag](root, numbers, joints)
    if joints and not there:
        raise RobotError(f"{source} has none of the joints of the result: {', '.join(sorted(joints))}.")
    written = tuple(pair for pair in numbers.at if pair in numbers.used)
    lacking = tuple(pair for pair in numbers.at if pair not in numbers.used)
    driven = {actuator.get("joint") for actuator in root.findall(POSITION)}
    bare = sorted({where for effect, where in lacking if effect in OF_ACTUATOR and where in there - driven})
    remarks = [f"{source} has no <position> actuator of {', '.join(bare)}: only such ones take effects of servos."]
    return Written(
        markup.with_changes(text, root), written, lacking, tuple(remarks) if bare and root.tag == "mujoco" else ()
    )


IN_URDF: Final = {"damping": ("viscous_friction", "factor"), "friction": ("coulomb_friction", "torque")}
"""Attributes of a joint's <dynamics>: the effect and the number that each is."""
IN_MJCF: Final = {  # likewise, of a joint
    "damping": ("viscous_friction", "factor"),
    "frictionloss": ("coulomb_friction", "torque"),
    "armature": ("rotor_inertia", "inertia"),
}
POSITION: Final = "actuator/position"
OF_ACTUATOR: Final = frozenset({"droop", "lag", "dead_time", "dead_zone", "range_limit"})  # what MJCF's has
OF_POSITION: Final = {"kp": (1, "1"), "kv": (1, "0"), "ctrlrange": (2, "-7 7")}
"""Attributes of a position actuator: how many numbers, MuJoCo's default, or a range of more than a turn [rad]."""
DEFAULT_STEP_S = "0.002"  # MuJoCo's


def _urdf(robot: ET.Element, numbers: _Numbers, joints: set[str]) -> set[str]:
    there = {name: joint for joint in robot.findall("joint") if (name := joint.get("name", "")) in joints}
    for name, joint in there.items():
        if attributes := numbers.attributes(name, IN_URDF):
            dynamics = joint.find("dynamics")
            dynamics = ET.SubElement(joint, "dynamics") if dynamics is None else dynamics
            dynamics.attrib.update(attributes)
    return set(there)


def _mjcf(root: ET.Element, numbers: _Numbers, joints: set[str], *, source: str) -> set[str]:
    there = {name: joint for joint in root.iter("joint") if (name := joint.get("name", "")) in joints}
    for name, joint in there.items():
        joint.attrib.update(numbers.attributes(name, IN_MJCF))
    option = root.find("option")
    timestep = DEFAULT_STEP_S if option is None else option.get("timestep", DEFAULT_STEP_S)
    (step,) = numbers_of(timestep, 1, "timestep of <option>", source)
    for actuator in root.findall(POSITION):
        name = actuator.get("joint", "")
        if name in there:
            known = {
                key: numbers_of(_of_class(root, actuator, key) or default, count, f"{key} of {name}", source, math.inf)
                for key, (count, default) in OF_POSITION.items()
            }
            _actuator(actuator, there[name], numbers, step, known)
    return set(there)


def _of_class(root: ET.Element, actuator: ET.Element, key: str) -> str | None:
    """An attribute of a position actuator: its own, or of its class of defaults or an enclosing one."""
    around = {inner: outer for outer in root.iter("default") for inner in outer.findall("default")}
    wanted = actuator.get("class")
    of_that = (one for one in root.iter("default") if one.get("class") == wanted)
    at, found = next(of_that, root.find("default")), actuator.get(key)
    while found is None and at is not None:
        position = at.find("position")
        at, found = around.get(at), None if position is None else position.get(key)
    return found


def _actuator(
    actuator: ET.Element, joint: ET.Element, numbers: _Numbers, step: float, known: Mapping[str, Array]
) -> None:
    name, (kp,), (kv,) = joint.get("name", ""), known["kp"], known["kv"]
    found = [numbers.take("droop", name, number, above=0.0) for number in ("compliance", "torque_compliance")]
    compliance = next((value for value in found if value is not None), None)
    gain = kp
    if compliance is not None:
        gain = 1.0 / compliance
        actuator.set("kp", digits(gain))
        if kv > 0.0 and kp > 0.0:  # the lag kv / kp stays
            actuator.set("kv", digits(gain * kv / kp))
    lag = numbers.take("lag", name, "time")
    if lag is not None:
        actuator.attrib.pop("dampratio", None)  # MuJoCo takes one of both
        actuator.set("kv", digits(gain * lag))
    delay = numbers.take("dead_time", name, "delay")
    if delay is not None and delay > 0.0:
        actuator.set("delay", digits(delay))
        actuator.set("nsample", str(int(delay / step) + 2))
    half_width = numbers.take("dead_zone", name, "half_width")
    if half_width is not None and ("coulomb_friction", name) not in numbers.used:
        joint.set("frictionloss", digits(gain * half_width))
    limits = [numbers.take("range_limit", name, end) for end in ("lower", "upper")]
    if any(end is not None for end in limits):
        actuator.attrib.pop("inheritrange", None)  # MuJoCo takes one of both
        actuator.set("ctrllimited", "true")
        ends = [own if end is None else end for end, own in zip(limits, known["ctrlrange"], strict=True)]
        actuator.set("ctrlrange", digits(np.array(ends)))


def placements_into(text: str, corrected: str, effects: Sequence[Mapping[str, Any]], source: str) -> Written:
    """Give the joints of a user's URDF the origins of the calibrated arm, robot_corrected.urdf.

    Raises:
        RobotError: The user's file is no URDF, has none of the joints, or other origins.
    """
    wanted, there = _origins(read_xml(corrected), "robot_corrected.urdf"), _origins(read_xml(text, source), source)
    shared = {name: T for name, T in wanted.items() if name in there}
    pairs = [(one["effect"], one["where"]) for one in effects]
    found = [pair for pair in pairs if pair[0] in OF_PLACEMENTS]
    written = tuple(pair for pair in found if shared and pair[1] in (*shared, "base"))
    if not written:
        raise RobotError(f"{source} has none of the joints of the result: {', '.join(where for _, where in found)}.")
    for name, T in shared.items():
        shift = float(np.linalg.norm(T[:3, 3] - there[name][:3, 3]))
        turn = float(np.arccos(np.clip((np.trace(T[:3, :3].T @ there[name][:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
        if shift > FARTHEST_M or turn > FARTHEST_RAD:
            raise RobotError(
                f"{source}: {name} is {1e3 * shift:.3g} mm and {np.degrees(turn):.3g}° off its placement in the"
                " calibrated arm. Is it another robot, or does it count its joints from other zeros?"
            )
    moved = {name: T for name, T in shared.items() if not np.array_equal(T, there[name])}
    return Written(with_placements(text, moved), written, tuple(pair for pair in pairs if pair not in written))


def _origins(robot: ET.Element, source: str) -> dict[str, Array]:
    """Placements of the moving joints."""
    return {
        name: origin_of(joint, f"joint '{name}'", source)
        for joint in robot.findall("joint")
        if (name := joint.get("name", "")) and joint.get("type") != "fixed"
    }


def zeros_into(text: str, effects: Sequence[Mapping[str, Any]], source: str) -> Written:
    """Change `homing_offset` in the text of a calibration file where the zero of a joint is wrong.

    A servo's position is its count less `homing_offset`, and LeRobot's angle is counted from the middle of
    `range_min` and `range_max`, which stay.

    Raises:
        DataError: It is no such file, lacks a joint, or has no room for the change; no zero is wrong, or by an unknown
            angle.
    """
    own = {one["where"]: one["parameters"] for one in effects if one["effect"] == "joint_offset"}
    offsets = {joint: found.get("offset", {}).get("value") for joint, found in own.items()}
    if lost := [joint for joint, offset in offsets.items() if offset is None]:
        raise DataError(f"The joint_offset of {lost[0]} has no offset in the result. Is its file complete?")
    if not offsets:
        raise DataError("The result names no joint with a wrong zero (joint_offset): there is nothing to write.")
    servos = read_servos(text, list(offsets), source)
    calibration = json.loads(text)
    remarks = []
    for joint, offset in offsets.items():
        before, after = servos[joint].homing_offset, servos[joint].homing_offset - round(offset / math.tau * TURN)
        if abs(after) > MOST:
            raise DataError(
                f"{source}: homing_offset of {joint} would become {after}, but a servo takes {-MOST} to {MOST}."
                " Put the servo's horn on again a few teeth further, and calibrate with LeRobot.",
                file=source,
            )
        calibration[joint]["homing_offset"] = after
        doubt = "" if own[joint]["offset"].get("std") else ", which the data do not determine by themselves"
        change = f"{joint}: homing_offset {before} -> {after} ticks"
        remarks.append(f"{change}; its zero was wrong by {math.degrees(offset):.2f}°{doubt}")
    written = tuple((one["effect"], one["where"]) for one in effects if one["effect"] == "joint_offset")
    lacking = tuple((one["effect"], one["where"]) for one in effects if one["effect"] != "joint_offset")
    return Written(json.dumps(calibration, indent=4) + "\n", written, lacking, tuple(remarks))
