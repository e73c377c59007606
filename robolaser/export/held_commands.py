"""Servos' delays for simulators, which hold each command until the next one.

A model of a log has each command at work from the row before on, so that an arm without delay is where it is told to
be. What is commanded row by row answers a row late by itself: to have the delay of the log, it needs a row less.
"""

from collections.abc import Mapping, Sequence
from typing import Any

LATE = (("dead_time", "delay"), ("lag", "time"))
"""Effects, and their numbers, that make a joint late; at low frequencies their sum is what counts."""


def less_hold(effects: Sequence[Mapping[str, Any]], step_s: float) -> list[dict[str, Any]]:
    """Effects whose dead times, then lags, are shorter by what a held command is late itself.

    Args:
        effects: As `effects` of diagnosis.json or calibration.json.
        step_s: The time from row to row.
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
