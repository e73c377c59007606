"""LeRobot's calibration file of an arm: the zero of each joint as a count of its servo."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import msgspec

from robolaser.errors import DataError

TURN: Final = 4096  # counts of a servo's turn


@final
@dataclass(frozen=True)
class MotorCalibration:
    """An entry of the file: `MotorCalibration` of lerobot/motors/motors_bus.py."""

    id: int
    homing_offset: int
    range_min: int
    range_max: int
    drive_mode: int = 0  # 1: LeRobot's per cent, but not its degrees, have the other sign

    @property
    def middle(self) -> float:
        """The position at which LeRobot reads 0°."""
        return (self.range_min + self.range_max) / 2


def read_servos(text: str, joints: Sequence[str], source: str) -> dict[str, MotorCalibration]:
    """The servos of required joints in a file's text, by the joints' names; the file's name is for messages."""
    try:
        found = msgspec.json.decode(text, type=dict[str, MotorCalibration])
    except (msgspec.DecodeError, RecursionError) as error:
        raise DataError(
            f"{source} is no calibration file of LeRobot (id, homing_offset, range_min and range_max of each joint):"
            f" {error}",
            file=source,
        ) from None
    missing = [joint for joint in joints if joint not in found]
    if missing:
        raise DataError(f"{source} lacks {', '.join(missing)}. It has {', '.join(found)}.", file=source)
    return {joint: found[joint] for joint in joints}
