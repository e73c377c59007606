"""Packets of bus servos: Dynamixel's protocol 2 and the STS protocol of Feetech, a descendant of Dynamixel's first."""

import re
from abc import ABC, abstractmethod
from typing import final

READ_ALL, WRITE_ALL = 0x82, 0x83
"""SYNC READ, which each servo answers in turn, and SYNC WRITE, which none answers."""
EVERYBODY = 0xFE
CRC_POLYNOMIAL = 0x8005


class Packets(ABC):
    """One framing; addresses and lengths are written in `wide` bytes, the lowest first."""

    wide: int

    @abstractmethod
    def instruction(self, code: int, parameters: bytes) -> bytes:
        """A packet to all servos."""

    @abstractmethod
    def answer(self, servo: int, length: int) -> bytes:
        """A pattern of the packet in which a servo answers with so many bytes, a group named data."""

    @abstractmethod
    def is_whole(self, packet: bytes) -> bool:
        """Whether a packet's check sum is right."""


@final
class DynamixelPackets(Packets):
    """FF FF FD 00, ID, length, instruction, parameters, CRC-16 (ROBOTIS e-Manual, DYNAMIXEL Protocol 2.0)."""

    wide = 2

    def instruction(self, code: int, parameters: bytes) -> bytes:
        """A packet to all servos; a header inside the parameters gets one more FD."""
        stuffed = parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        packet = b"\xff\xff\xfd\0" + bytes([EVERYBODY]) + (len(stuffed) + 3).to_bytes(2, "little")
        packet += bytes([code]) + stuffed
        return packet + crc16(packet).to_bytes(2, "little")

    def answer(self, servo: int, length: int) -> bytes:
        """A pattern of a status packet: instruction 55 hex, an error, the data."""
        head = b"\xff\xff\xfd\0" + bytes([servo]) + (length + 4).to_bytes(2, "little") + b"\x55"
        return re.escape(head) + b"[\0-\xff](?P<data>[\0-\xff]{%d})[\0-\xff]{2}" % length

    def is_whole(self, packet: bytes) -> bool:
        """Whether the CRC is right."""
        return crc16(packet[:-2]) == int.from_bytes(packet[-2:], "little")


@final
class StsPackets(Packets):
    """FF FF, ID, length, instruction, parameters, inverted sum (Feetech, SMS and STS protocol manual)."""

    wide = 1

    def instruction(self, code: int, parameters: bytes) -> bytes:
        """A packet to all servos."""
        body = bytes([EVERYBODY, len(parameters) + 2, code]) + parameters
        return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])

    def answer(self, servo: int, length: int) -> bytes:
        """A pattern of a status packet: an error, the data."""
        head = b"\xff\xff" + bytes([servo, length + 2])
        return re.escape(head) + b"[\0-\xff](?P<data>[\0-\xff]{%d})[\0-\xff]" % length

    def is_whole(self, packet: bytes) -> bool:
        """Whether the sum is right."""
        return ~sum(packet[2:-1]) & 0xFF == packet[-1]


def crc16(data: bytes) -> int:
    """CRC-16 with polynomial 8005 hex from 0, the highest bit first."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (CRC_POLYNOMIAL if crc & 0x8000 else 0)) & 0xFFFF
    return crc
