"""Where bus servos keep what: numbered registers, by the makers' tables (DYNAMIXEL X series; Feetech STS3215)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from robolaser.cell.servo_packets import DynamixelPackets, Packets, StsPackets


@final
@dataclass(frozen=True)
class Registers:
    """Where a servo keeps what: an address and a number of bytes each.

    Attributes:
        torque: Whether the motor holds.
        goal: Where it goes.
        motion: The goal and how to get there, in one piece.
        present: Where it is.
        status: Bits of `TROUBLE`.
        signed_by_bit: Whether the highest bit of a position is its sign.
    """

    packets: Packets
    torque: tuple[int, int]
    goal: tuple[int, int]
    motion: tuple[int, int]
    present: tuple[int, int]
    status: tuple[int, int]
    signed_by_bit: bool = False
    drive_mode: tuple[int, int] | None = None


SERVOS: Mapping[str, Registers] = {
    "dynamixel": Registers(DynamixelPackets(), (64, 1), (116, 4), (108, 12), (132, 4), (70, 1), drive_mode=(10, 1)),
    "feetech": Registers(StsPackets(), (40, 1), (42, 2), (41, 7), (56, 2), (65, 1), signed_by_bit=True),
}
