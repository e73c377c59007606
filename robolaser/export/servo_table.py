"""Effects of a moving arm as a table of gains and dead bands, in the terms of Isaac Lab and ROS."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from robolaser.data.csv_tables import table_text

FILE: Final = "servos.csv"
HEADER: Final = ("joint", "effect", "number", "value", "std", "unit", "probability", "isaac_lab", "ros")

STIFFNESS: Final = ("stiffness = {1:.4g}", "position gain {1:.4g} Nm/rad")
WORDS: Final[Mapping[tuple[str, str], tuple[str, str]]] = {
    ("dead_time", "delay"): (
        "DelayedPDActuatorCfg: min_delay = max_delay = {0:.4g} s / physics step",
        "position command delayed by {0:.4g} s",
    ),
    ("lag", "time"): ("damping = {0:.4g} s * stiffness", "first-order filter of the position command, {0:.4g} s"),
    ("droop", "compliance"): STIFFNESS,
    ("droop", "torque_compliance"): STIFFNESS,
    ("dead_zone", "half_width"): (
        "friction = {0:.4g} rad * stiffness",
        "dead band of ±{0:.4g} rad in the position loop",
    ),
    ("play", "half_width"): ("", "play of ±{0:.4g} rad behind the gear"),
    ("speed_limit", "speed"): ("velocity_limit_sim = {0:.4g}", "joint_limits: max_velocity: {0:.4g}"),
    ("range_limit", "lower"): ("", "joint_limits: min_position: {0:.4g}"),
    ("range_limit", "upper"): ("", "joint_limits: max_position: {0:.4g}"),
    ("viscous_friction", "factor"): ("viscous_friction = {0:.4g}", 'URDF: <dynamics damping="{0:.4g}"/>'),
    ("coulomb_friction", "torque"): ("friction = dynamic_friction = {0:.4g}", 'URDF: <dynamics friction="{0:.4g}"/>'),
    ("rotor_inertia", "inertia"): ("armature = {0:.4g}", ""),
}
"""By effect and number: the terms of Isaac Lab's actuators and of ROS for the number, 0, or one over it, 1; empty where
they have none."""

LATE: Final = (("dead_time", "delay"), ("lag", "time"))
"""Effects, and their numbers, that delay a joint; at low frequencies their sum counts."""


def servo_table(effects: Sequence[Mapping[str, Any]], step_s: float = 0.0) -> str:
    """A row for each number of a motion's effects, CSV, including numbers for which neither has a term.

    The time from row to row of its log is the delay of simulators that hold commands.
    """
    rows = []
    for one, held in zip(effects, less_hold(effects, step_s), strict=True):
        for name, number in one["parameters"].items():
            value, simulated = number["value"], held["parameters"][name]["value"]
            words = [_with_number(each, simulated) for each in WORDS.get((one["effect"], name), ("", ""))]
            known = repr(float(value)), "" if number["std"] is None else f"{number['std']:.3g}", number["unit"]
            rows.append([one["where"], one["effect"], name, *known, f"{one['probability']:.3f}", *words])
    return table_text(HEADER, rows)


def _with_number(words: str, value: float) -> str:
    """A term with its number; none for the stiffness of a rigid part."""
    return "" if "{1" in words and not value > 0.0 else words.format(value, 1.0 / (value or 1.0))


def less_hold(effects: Sequence[Mapping[str, Any]], step_s: float) -> list[dict[str, Any]]:
    """Effects with dead times, then lags, reduced by the delay of a held command: for simulators.

    In a model of a log each command acts from the row before on, so that an arm without delay is at its command.
    Simulators hold each command until the next one, a delay of one row: for the delay of the log, they need a row less.
    """
    left = {one["where"]: step_s for one in effects}
    found = [dict(one) for one in effects]
    for effect, number in LATE:
        for one in found:
            if one["effect"] == effect and number in one["parameters"]:
                known = one["parameters"][number]
                taken = min(left[one["where"]], known["value"])
                left[one["where"]] -= taken
                one["parameters"] = {**one["parameters"], number: {**known, "value": known["value"] - taken}}
    return found
