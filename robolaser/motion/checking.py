"""What a log of a moving arm allows, before anything is fitted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.motion.linear_rows import candidates_of
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import quantities
from robolaser.motion.torques import unusable_torque
from robolaser.motion.tracking import TrackingRows


@final
@dataclass(frozen=True)
class MotionCheck:
    """Kinds of rows that there are, and the effects that they can show."""

    log: MotionLog
    kinds: tuple[str, ...]
    tested: Mapping[str, tuple[str, ...]]  # places by effect
    not_tested: Mapping[str, str]  # reasons by effect

    def to_dict(self) -> dict[str, Any]:
        """As the command prints it with --json."""
        return {
            "dataset": self.log.name,
            "kind": "motion",
            "rows": len(self.log),
            "series": len(self.log.series),
            "joints": list(self.log.joints),
            "row_kinds": list(self.kinds),
            "effects": [
                *({"effect": name, "where": list(where)} for name, where in self.tested.items()),
                *({"effect": name, "where": [], "reason": reason} for name, reason in self.not_tested.items()),
            ],
        }


def check_motion(log: MotionLog) -> MotionCheck:
    """Say which rows a log has and which effects they can show."""
    tested: dict[str, tuple[str, ...]] = {}
    missing: dict[str, str] = {}
    kinds = []
    if (log.has("command") & log.has("q")).any():
        kinds.append("tracking")
        rows = TrackingRows(log)
        for joint in rows.joints.tolist():
            found, absent = rows.candidates(MOTION_EFFECTS, joint)
            missing |= absent
            for one in found:
                tested[one.effect.name] = tuple(dict.fromkeys((*tested.get(one.effect.name, ()), one.where)))
    reason = unusable_torque(log) if log.has("tau").any() else "no torques in the data"
    linear = {"torque": reason, "load": "" if log.has("load").any() else "no encoder behind the gear in the data"}
    for kind, lack in linear.items():
        if lack:
            missing |= {one.name: lack for one in MOTION_EFFECTS if one.rows == kind}
            continue
        kinds.append(kind)
        candidates, absent = candidates_of(quantities(log, kind), MOTION_EFFECTS, kind)
        missing |= absent
        for one in candidates:
            tested[one.effect.name] = tuple(dict.fromkeys((*tested.get(one.effect.name, ()), one.where)))
    if "tracking" not in kinds:
        missing |= {one.name: "no commands in the data" for one in MOTION_EFFECTS if one.rows == "tracking"}
    return MotionCheck(log, tuple(kinds), tested, {name: why for name, why in missing.items() if name not in tested})
