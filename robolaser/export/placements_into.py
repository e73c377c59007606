"""Calibrated placements of joints written into a copy of a URDF that a user already has."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.export.into import Written
from robolaser.model.effects import EFFECTS
from robolaser.robot.urdf.checking import read_xml
from robolaser.robot.urdf.editing import with_placements
from robolaser.robot.urdf.numbers import origin_of

FARTHEST_M, FARTHEST_RAD = 0.05, 0.3
"""By which a joint of the same robot can be off at most: more, and the files describe two robots."""
IN_URDF: Final = frozenset(effect.name for effect in EFFECTS if effect.in_urdf)


def placements_into(text: str, corrected: str, effects: Sequence[Mapping[str, Any]], source: str) -> Written:
    """Give the joints of a URDF the origins that they have in another one.

    Args:
        text: The user's file.
        corrected: The calibrated arm, robot_corrected.urdf.
        effects: As `effects` of calibration.json or diagnosis.json.
        source: What error messages call the file.

    Raises:
        RobotError: The user's file is no URDF, has none of the joints, or has them elsewhere.
    """
    wanted, there = _origins(read_xml(corrected), "robot_corrected.urdf"), _origins(read_xml(text, source), source)
    shared = {name: T for name, T in wanted.items() if name in there and name not in _fixed(read_xml(text, source))}
    if not shared:
        raise RobotError(f"{source} has none of the joints of the result: {', '.join(wanted)}.")
    for name, T in shared.items():
        shift = float(np.linalg.norm(T[:3, 3] - there[name][:3, 3]))
        turn = float(np.arccos(np.clip((np.trace(T[:3, :3].T @ there[name][:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
        if shift > FARTHEST_M or turn > FARTHEST_RAD:
            raise RobotError(
                f"{source}: {name} stands {1e3 * shift:.3g} mm and {np.degrees(turn):.3g}° from where the calibrated"
                " arm has it. Is it another robot, or does it count its joints from other zeros?"
            )
    pairs = [(one["effect"], one["where"]) for one in effects]
    written = tuple(pair for pair in pairs if pair[0] in IN_URDF and (pair[1] in shared or pair[1] == "base"))
    return Written(with_placements(text, shared), written, tuple(pair for pair in pairs if pair not in written))


def _origins(robot: ET.Element, source: str) -> dict[str, Array]:
    return {
        name: origin_of(joint, f"joint '{name}'", source)
        for joint in robot.findall("joint")
        if (name := joint.get("name", ""))
    }


def _fixed(robot: ET.Element) -> set[str]:
    return {joint.get("name", "") for joint in robot.findall("joint") if joint.get("type") == "fixed"}
