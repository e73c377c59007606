"""What was found on a moving arm as a table of gains and dead bands, in the words of Isaac Lab and ROS."""

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

FILE: Final = "servos.csv"
HEADER: Final = ("joint", "effect", "number", "value", "unit", "probability", "isaac_lab", "ros")

Words = tuple[Callable[[float], str], Callable[[float], str]]


def _none(value: float) -> str:
    return ""


_STIFFNESS: Final[Words] = (
    lambda v: f"stiffness = {1.0 / v:.4g}" if v > 0.0 else "",
    lambda v: f"position gain {1.0 / v:.4g} Nm/rad" if v > 0.0 else "",
)
WORDS: Final[Mapping[tuple[str, str], Words]] = {
    ("dead_time", "delay"): (
        lambda v: f"DelayedPDActuatorCfg: min_delay = max_delay = {v:.4g} s / physics step",
        lambda v: f"position command delayed by {v:.4g} s",
    ),
    ("lag", "time"): (
        lambda v: f"damping = {v:.4g} s * stiffness",
        lambda v: f"first-order filter of the position command, {v:.4g} s",
    ),
    ("droop", "compliance"): _STIFFNESS,
    ("droop", "torque_compliance"): _STIFFNESS,
    ("dead_zone", "half_width"): (
        lambda v: f"friction = {v:.4g} rad * stiffness",
        lambda v: f"dead band of ±{v:.4g} rad in the position loop",
    ),
    ("play", "half_width"): (_none, lambda v: f"play of ±{v:.4g} rad behind the gear"),
    ("speed_limit", "speed"): (
        lambda v: f"velocity_limit_sim = {v:.4g}",
        lambda v: f"joint_limits: max_velocity: {v:.4g}",
    ),
    ("range_limit", "lower"): (_none, lambda v: f"joint_limits: min_position: {v:.4g}"),
    ("range_limit", "upper"): (_none, lambda v: f"joint_limits: max_position: {v:.4g}"),
    ("viscous_friction", "factor"): (
        lambda v: f"viscous_friction = {v:.4g}",
        lambda v: f'URDF: <dynamics damping="{v:.4g}"/>',
    ),
    ("coulomb_friction", "torque"): (
        lambda v: f"friction = dynamic_friction = {v:.4g}",
        lambda v: f'URDF: <dynamics friction="{v:.4g}"/>',
    ),
    ("rotor_inertia", "inertia"): (lambda v: f"armature = {v:.4g}", _none),
}
"""By effect and number: what Isaac Lab's actuators and ROS call it; empty where they have no such thing."""


def servo_table(effects: Sequence[Mapping[str, Any]]) -> str:
    """A row for each number, CSV; all numbers are there, also those for which neither simulator has a word.

    Args:
        effects: As `effects` of a motion's diagnosis.json.
    """
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(HEADER)
    for one in effects:
        for name, number in one["parameters"].items():
            isaac, ros = WORDS.get((one["effect"], name), (_none, _none))
            value = number["value"]
            known = [one["where"], one["effect"], name, repr(float(value)), number["unit"], f"{one['probability']:.3f}"]
            table.writerow([*known, isaac(value), ros(value)])
    return out.getvalue()
