"""Where bus servos keep what: numbered registers, by the makers' tables (DYNAMIXEL X series; Feetech STS3215)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from robolaser.cell.servo_packets import DynamixelPackets, Packets, StsPackets

WRONG_VOLTAGE, TOO_HOT, OVERLOADED = "wrong voltage", "too hot", "overloaded"
NO_READING = "no reading of its encoder"


@final
@dataclass(frozen=True)
class Registers:
    """Where a servo keeps what: an address and a number of bytes each.

    Attributes:
        torque: Whether the motor holds.
        goal: Where it goes.
        motion: The goal and how to get there, in one piece.
        present: Where it is.
        status: Bits of `trouble`.
        trouble: What each bit of the status means.
        signed_by_bit: Whether the highest bit of a position is its sign.
    """

    packets: Packets
    torque: tuple[int, int]
    goal: tuple[int, int]
    motion: tuple[int, int]
    present: tuple[int, int]
    status: tuple[int, int]
    trouble: Mapping[int, str]
    signed_by_bit: bool = False
    drive_mode: tuple[int, int] | None = None


SERVOS: Mapping[str, Registers] = {
    "dynamixel": Registers(
        DynamixelPackets(),
        torque=(64, 1),
        goal=(116, 4),
        motion=(108, 12),
        present=(132, 4),
        status=(70, 1),
        trouble={1: WRONG_VOLTAGE, 4: TOO_HOT, 8: NO_READING, 16: "electrical shock", 32: OVERLOADED},
        drive_mode=(10, 1),
    ),
    "feetech": Registers(
        StsPackets(),
        torque=(40, 1),
        goal=(42, 2),
        motion=(41, 7),
        present=(56, 2),
        status=(65, 1),
        trouble={1: WRONG_VOLTAGE, 2: NO_READING, 4: TOO_HOT, 8: "too much current", 32: OVERLOADED},
        signed_by_bit=True,
    ),
}
