"""Zeros of joints written into a copy of LeRobot's calibration file of an arm with Feetech servos."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from robolaser.data.lerobot import TURN, read_servos
from robolaser.errors import DataError
from robolaser.export.into import Written

MOST: Final = 2047
"""Of a homing_offset, which has eleven bits and a sign [ticks]."""


def zeros_into(text: str, effects: Sequence[Mapping[str, Any]], source: str) -> Written:
    """Change `homing_offset` where the zero of a joint is wrong.

    A servo's position is its count less `homing_offset`, and LeRobot's angle is counted from the middle of
    `range_min` and `range_max`, which stay.

    Args:
        text: The calibration file.
        effects: As `effects` of diagnosis.json or calibration.json.
        source: What error messages call the file.

    Raises:
        DataError: It is no such file, lacks a joint, or has no room for the change; no zero is wrong.
    """
    offsets = {one["where"]: one["parameters"]["offset"]["value"] for one in effects if one["effect"] == "joint_offset"}
    if not offsets:
        raise DataError("The result names no joint with a wrong zero (joint_offset): there is nothing to write.")
    servos = read_servos(text, list(offsets), source)
    calibration = json.loads(text)
    remarks = []
    for joint, offset in offsets.items():
        before, after = servos[joint].homing_offset, servos[joint].homing_offset - round(offset / math.tau * TURN)
        if abs(after) > MOST:
            raise DataError(
                f"{source}: homing_offset of {joint} would become {after}, but a servo takes {-MOST} to {MOST}. Put the"
                " servo's horn on again a few teeth further, and calibrate with LeRobot.",
                file=source,
            )
        calibration[joint]["homing_offset"] = after
        degrees = math.degrees(offset)
        remarks.append(f"{joint}: homing_offset {before} -> {after} ticks; its zero was wrong by {degrees:.2f}°")
    written = tuple((one["effect"], one["where"]) for one in effects if one["effect"] == "joint_offset")
    lacking = tuple((one["effect"], one["where"]) for one in effects if one["effect"] != "joint_offset")
    return Written(json.dumps(calibration, indent=4) + "\n", written, lacking, tuple(remarks))
