"""Which kinds of rows a log has, and why it lacks others."""

from robolaser.motion.effect import Kind
from robolaser.motion.log import MotionLog

LACKING: dict[Kind, str] = {
    "tracking": "no commands in the data",
    "torque": "no torques in the data",
    "load": "no encoder behind the gear in the data",
}


def comparable(log: MotionLog) -> dict[Kind, str]:
    """Why there are no rows of a kind; "" where there are some."""
    read = log.has("q")
    there: dict[Kind, bool] = {
        "tracking": bool((log.has("command") & read).any()),
        "torque": bool(log.has("tau").any()),
        "load": bool((log.has("load") & read).any()),
    }
    reasons = {kind: "" if there[kind] else lack for kind, lack in LACKING.items()}
    return reasons | ({"torque": unusable_torque(log)} if there["torque"] else {})


def unusable_torque(log: MotionLog) -> str:
    """Why a log's torques are set aside; "" where they are not."""
    if not log.torque_signed:
        return "the torques have no sign"
    if log.torque_unit != "Nm":
        return (
            f"the torques are given in {log.torque_unit} and no torque constant is known: mass and constant cannot be"
            " distinguished"
        )
    return ""
