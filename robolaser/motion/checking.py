"""Which rows and effects a log of a moving arm can show, before anything is fitted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from robolaser.motion.effect import At, RowKind
from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.motion.linear_rows import candidates_of
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import quantities
from robolaser.motion.tracking import TrackingRows

LACKING: dict[RowKind, str] = {
    "tracking": "no commands in the data",
    "torque": "no torques in the data",
    "load": "no encoder behind the gear in the data",
}


def comparable(log: MotionLog) -> dict[RowKind, str]:
    """Reasons why there are no rows of a kind; "" where there are some."""
    reasons, read = dict(LACKING), log.has("q")
    if (log.has("command") & read).any():
        both = np.isfinite(log.command) & np.isfinite(log.q)
        alike = "the readings are the commands, digit by digit"
        reasons["tracking"] = "" if (both & (log.command != log.q)).any() else alike
        if not both.any():
            reasons["tracking"] = "no row has both a command and a reading of a joint"
    if log.has("tau").any():
        reasons["torque"] = _unusable_torque(log)
    if (log.has("load") & read).any():
        reasons["load"] = ""
    return reasons


def _unusable_torque(log: MotionLog) -> str:
    """Reason why a log's torques are set aside; "" where they are used."""
    if not log.has_signs:
        return "the torques have no sign" + (": none is negative" if log.torque_signed else "")
    if log.torque_unit != "Nm":
        return (
            f"the torques are given in {log.torque_unit} and no torque constant is known: mass and constant cannot be"
            " distinguished"
        )
    return ""


@final
@dataclass(frozen=True)
class MotionCheck:
    """The kinds of rows in a log, and the effects that they can show."""

    log: MotionLog
    kinds: tuple[str, ...]
    tested: Mapping[str, tuple[str, ...]]  # locations by effect
    not_tested: Mapping[str, str]  # reasons by effect

    def to_dict(self) -> dict[str, Any]:
        """The output of `--json`."""
        found = [{"effect": name, "where": list(where)} for name, where in self.tested.items()]
        absent = [{"effect": name, "where": [], "reason": reason} for name, reason in self.not_tested.items()]
        return {
            "dataset": self.log.name, "kind": "motion", "rows": len(self.log), "series": len(self.log.series),
            "joints": list(self.log.joints), "row_kinds": list(self.kinds), "effects": [*found, *absent],
        }  # fmt: skip


def check_motion(log: MotionLog) -> MotionCheck:
    """Say which rows a log has and which effects they can show."""
    reasons = comparable(log)
    missing = {one.name: reasons[one.rows] for one in MOTION_EFFECTS if reasons[one.rows]}
    found: list[At] = []
    if not reasons["tracking"]:
        of_joints, absent = TrackingRows(log).candidates(MOTION_EFFECTS)
        missing |= absent
        found += [at for candidates in of_joints for at in candidates]
    for kind in ("torque", "load"):
        if not reasons[kind]:
            candidates, absent = candidates_of(quantities(log, kind), MOTION_EFFECTS, kind)
            missing |= absent
            found += candidates
    tested: dict[str, tuple[str, ...]] = {}
    for one in found:
        tested[one.effect.name] = tuple(dict.fromkeys((*tested.get(one.effect.name, ()), one.where)))
    kinds = tuple(kind for kind, reason in reasons.items() if not reason)
    return MotionCheck(log, kinds, tested, {name: why for name, why in missing.items() if name not in tested})
