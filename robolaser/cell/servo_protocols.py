"""What is sent to bus servos of a family: packets, numbered registers, and what a motion is made of.

A register is an address and a number of bytes; addresses and lengths are written in `wide` bytes, the lowest first.
`torque`: whether the motor holds; `goal`: where it goes; `motion`: the goal and how to get there, in one piece;
`present`: where it is; `status`: bits of `trouble`; `drive_mode`: how motions are stated, if there are several ways.

Dynamixel: ROBOTIS e-Manual, DYNAMIXEL Protocol 2.0 and X series. Feetech: SMS and STS protocol manual, STS3215; a
descendant of Dynamixel's first protocol.
"""

import re
from collections.abc import Mapping
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Ints

READ_ALL, WRITE_ALL = 0x82, 0x83  # SYNC READ, which each servo answers in turn, and SYNC WRITE, which none answers
EVERYBODY = 0xFE
CRC_POLYNOMIAL = 0x8005
RAMP = 0.25  # share of a motion's time in which it gains speed
STEEPEST = 254  # acceleration of Feetech's servos at most [100 steps/s2]
BRAKING = 100, STEEPEST  # speed [steps/s] and acceleration [100 steps/s2] of Feetech's servos that are told to stop
WRONG_VOLTAGE, TOO_HOT, OVERLOADED = "wrong voltage", "too hot", "overloaded"
NO_READING = "no reading of its encoder"

Register = tuple[int, int]


@final
class Dynamixel:
    """FF FF FD 00, ID, length, instruction, parameters, CRC-16."""

    wide = 2
    torque, goal, motion, present, status, drive_mode = (64, 1), (116, 4), (108, 12), (132, 4), (70, 1), (10, 1)
    trouble: ClassVar[Mapping[int, str]] = {
        1: WRONG_VOLTAGE, 4: TOO_HOT, 8: NO_READING, 16: "electrical shock", 32: OVERLOADED
    }  # fmt: skip

    def instruction(self, code: int, parameters: bytes) -> bytes:
        """A packet to all servos; a header inside the parameters gets one more FD."""
        stuffed = parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        packet = b"\xff\xff\xfd\0" + bytes([EVERYBODY]) + (len(stuffed) + 3).to_bytes(2, "little")
        packet += bytes([code]) + stuffed
        return packet + crc16(packet).to_bytes(2, "little")

    def answer(self, servo: int, length: int) -> bytes:
        """A pattern of the packet in which a servo answers: instruction 55 hex, an error, the data."""
        head = b"\xff\xff\xfd\0" + bytes([servo]) + (length + 4).to_bytes(2, "little") + b"\x55"
        return re.escape(head) + b"[\0-\xff](?P<data>[\0-\xff]{%d})[\0-\xff]{2}" % length

    def is_whole(self, packet: bytes) -> bool:
        """Whether the CRC is right."""
        return crc16(packet[:-2]) == int.from_bytes(packet[-2:], "little")

    def motion_data(self, way: int, goal: int, seconds: float) -> bytes:
        """Times of ramp and motion [ms], and the goal [steps]; in 0 s: stop."""
        times = round(1000 * RAMP * seconds), round(1000 * seconds), goal
        return b"".join(number.to_bytes(4, "little", signed=True) for number in times)

    def setpoint(self, goal: int) -> bytes:
        """To go to a goal without a ramp: times of 0."""
        return self.motion_data(0, goal, 0.0)

    def positions(self, raw: Ints, length: int) -> Ints:
        """Positions from what registers of so many bytes hold, (j,) [steps]: two's complement."""
        return np.where(raw < 1 << 8 * length - 1, raw, raw - (1 << 8 * length))


@final
class Feetech:
    """FF FF, ID, length, instruction, parameters, inverted sum."""

    wide = 1
    torque, goal, motion, present, status, drive_mode = (40, 1), (42, 2), (41, 7), (56, 2), (65, 1), None
    trouble: ClassVar[Mapping[int, str]] = {
        1: WRONG_VOLTAGE, 2: NO_READING, 4: TOO_HOT, 8: "too much current", 32: OVERLOADED
    }  # fmt: skip

    def instruction(self, code: int, parameters: bytes) -> bytes:
        """A packet to all servos."""
        body = bytes([EVERYBODY, len(parameters) + 2, code]) + parameters
        return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])

    def answer(self, servo: int, length: int) -> bytes:
        """A pattern of the packet in which a servo answers: an error, the data."""
        head = b"\xff\xff" + bytes([servo, length + 2])
        return re.escape(head) + b"[\0-\xff](?P<data>[\0-\xff]{%d})[\0-\xff]" % length

    def is_whole(self, packet: bytes) -> bool:
        """Whether the sum is right."""
        return ~sum(packet[2:-1]) & 0xFF == packet[-1]

    def motion_data(self, way: int, goal: int, seconds: float) -> bytes:
        """Acceleration [100 steps/s2], goal, a time that is not used, speed to go so far [steps/s]; in 0 s: stop."""
        speed, ramp = BRAKING
        if seconds:
            speed = max(1, round(way / (seconds * (1 - RAMP))))
            ramp = min(STEEPEST, max(1, round(speed / (RAMP * seconds) / 100)))
        return bytes([ramp]) + _signed(goal) + b"\0\0" + speed.to_bytes(2, "little")

    def setpoint(self, goal: int) -> bytes:
        """To go to a goal without a ramp: the highest acceleration; a speed of 0 is no limit."""
        return bytes([STEEPEST]) + _signed(goal) + b"\0\0\0\0"

    def positions(self, raw: Ints, length: int) -> Ints:
        """Positions from what registers of so many bytes hold, (j,) [steps]: the highest bit is the sign."""
        highest = 1 << 8 * length - 1
        return np.where(raw < highest, raw, highest - raw)


def _signed(position: int) -> bytes:
    """The highest bit is the sign."""
    return (abs(position) | (0x8000 if position < 0 else 0)).to_bytes(2, "little")


def crc16(data: bytes) -> int:
    """CRC-16 with polynomial 8005 hex from 0, the highest bit first."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (CRC_POLYNOMIAL if crc & 0x8000 else 0)) & 0xFFFF
    return crc


SERVOS: Mapping[str, Dynamixel | Feetech] = {"dynamixel": Dynamixel(), "feetech": Feetech()}  # by the kind of arm
