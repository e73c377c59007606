"""Zeros in a copy of LeRobot's calibration."""

import json
import math
from typing import Any

import pytest

from robolaser.errors import DataError
from robolaser.export.into import zeros_into

SERVO = {"id": 3, "drive_mode": 0, "homing_offset": -562, "range_min": 868, "range_max": 3094}
CALIBRATION = {"elbow_flex": SERVO, "gripper": {**SERVO, "id": 6}}
PLAY = {"effect": "backlash", "where": "elbow_flex", "parameters": {}}


def offset(value: float, where: str = "elbow_flex") -> dict[str, Any]:
    return {"effect": "joint_offset", "where": where, "parameters": {"offset": {"value": value}}}


def read_degrees(actual: int, servo: dict[str, int]) -> float:
    """As LeRobot reads a count, by motors/feetech/feetech.py and motors/motors_bus.py."""
    return (actual - servo["homing_offset"] - (servo["range_min"] + servo["range_max"]) / 2) * 360 / 4095


@pytest.mark.parametrize("angle", [0.05, -0.05])
def test_lerobot_then_reads_what_the_joint_was_found_to_be_at(angle: float) -> None:
    written = zeros_into(json.dumps(CALIBRATION), [offset(angle), PLAY], "my_arm.json")
    changed = json.loads(written.text)
    before, after = (read_degrees(1800, one["elbow_flex"]) for one in (CALIBRATION, changed))
    assert after - before == pytest.approx(math.degrees(angle), abs=360 / 4096)
    assert written.contains == (("joint_offset", "elbow_flex"),)
    assert written.lacks == (("backlash", "elbow_flex"),)
    changed["elbow_flex"]["homing_offset"] = SERVO["homing_offset"]
    assert changed == CALIBRATION


@pytest.mark.parametrize(
    ("text", "effects", "match"),
    [
        ("{", [offset(0.05)], "no calibration file of LeRobot"),
        ('{"elbow_flex": {"deep": ' + "[" * 100_000, [offset(0.05)], "no calibration file of LeRobot"),
        ('{"elbow_flex": {"id": 3}}', [offset(0.05)], "homing_offset"),
        (json.dumps(CALIBRATION), [offset(0.05, "shoulder_pan")], "lacks shoulder_pan"),
        (json.dumps(CALIBRATION), [{**offset(0.05), "parameters": {}}], "joint_offset of elbow_flex has no offset"),
        (json.dumps(CALIBRATION), [PLAY], "no joint with a wrong zero"),
        (json.dumps({"elbow_flex": {**SERVO, "homing_offset": -2040}}), [offset(0.05)], "would become -2073"),
    ],
)
def test_what_cannot_be_written_is_refused(text: str, effects: list[dict[str, Any]], match: str) -> None:
    with pytest.raises(DataError, match=match):
        zeros_into(text, effects, "my_arm.json")
