"""Whether recorded torques can be held against inverse dynamics."""

from robolaser.motion.log import MotionLog


def unusable_torque(log: MotionLog) -> str:
    """Why a log's torques are set aside; "" where they are not."""
    if not log.torque_signed:
        return "the torques have no sign"
    if log.torque_unit != "Nm":
        return (
            f"the torques are given in {log.torque_unit} and no torque constant is known: mass and constant cannot be"
            " told apart"
        )
    return ""
