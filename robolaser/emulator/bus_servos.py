"""Servos on one line with numbered registers: Dynamixel's X series, and Feetech's STS series."""

from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import Cell
from robolaser.emulator.controller import FASTEST_RAD_S, ArmFault, ServoChain, least_seconds
from robolaser.emulator.servo_loop import ServoLoop

TURN = 4096
MIDDLE = 2048
REGISTERS = 256
HOT, OVERLOADED = 4, 32
SYNC_READ, SYNC_WRITE = 0x82, 0x83
ALL = 0xFE


@final
class BusServos(ServoChain):
    """A chain of servos that all receive every packet; a position of 2048 is the middle."""

    command_mark: ClassVar[bytes] = b"\xff\xff"

    def __init__(self, cell: Cell, loop: ServoLoop | None = None) -> None:
        super().__init__(cell)
        self._loop = loop
        self._memory = {servo: bytearray(REGISTERS) for servo in self._ids}
        self._dynamixel = cell.arm.kind == "dynamixel"
        registers = (64, 116, 132, 70) if self._dynamixel else (40, 42, 56, 65)
        self._torque, self._goal, self._present, self._status = registers
        self._size = 4 if self._dynamixel else 2
        self._heard = b""

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Receive packets, and answer requests."""
        self._heard += data
        self.motor(now_s)  # the joints followed earlier commands until now
        answers = b""
        while (packet := self._next_packet()) is not None:
            answers += self._obey(*packet, now_s)
        return answers

    def motor(self, now_s: float) -> Array:
        """Joint angles as the encoders see them, (j,) [rad]."""
        wanted = super().motor
        return wanted(now_s) if self._loop is None else self._loop.follow(wanted, now_s)

    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Cause a fault; servos have no homing."""
        if fault is ArmFault.STALL:
            self._axes[axis - 1].jam(now_s)
            return
        for i in range(len(self._ids)) if fault is ArmFault.REBOOT else [axis - 1]:
            self._axes[i].halt(now_s)
            self._memory[self._ids[i]][self._torque] = 0
        if fault in (ArmFault.IMPACT, ArmFault.THERMIC):
            self._memory[self._ids[axis - 1]][self._status] = OVERLOADED if fault is ArmFault.IMPACT else HOT

    def _next_packet(self) -> tuple[int, int, bytes] | None:
        """Address, instruction and parameters of the next complete packet."""
        header = b"\xff\xff\xfd\x00" if self._dynamixel else b"\xff\xff"
        while (start := self._heard.find(header)) >= 0:
            body = self._heard[start + len(header) :]
            if len(body) < (3 if self._dynamixel else 2):
                return None
            size = (3 + body[1] + 256 * body[2]) if self._dynamixel else 2 + body[1]
            if len(body) < size:
                return None
            packet, self._heard = self._heard[start : start + len(header) + size], body[size:]
            if self._dynamixel and size >= 6 and _crc(packet[:-2]) == packet[-2] + 256 * packet[-1]:
                return body[0], body[3], body[4 : size - 2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
            if not self._dynamixel and size >= 4 and (sum(packet[2:]) & 0xFF) == 0xFF:
                return body[0], body[2], body[3 : size - 1]
        return None

    def _obey(self, servo: int, instruction: int, parameters: bytes, now_s: float) -> bytes:
        width = 2 if self._dynamixel else 1
        address = int.from_bytes(parameters[:width], "little")
        rest = parameters[width:]
        length = int.from_bytes(rest[:width], "little")
        if instruction == SYNC_READ and servo == ALL:
            return b"".join(self._answer(one, address, length, now_s) for one in rest[width:] if one in self._memory)
        if instruction == SYNC_WRITE and servo == ALL:
            for k in range(width, len(rest), length + 1):
                if rest[k] in self._memory:
                    self._store(rest[k], address, rest[k + 1 : k + 1 + length], now_s)
        return b""

    def _answer(self, servo: int, address: int, length: int, now_s: float) -> bytes:
        i = self._ids.index(servo)
        memory, turned = self._memory[servo], self._turned(i, float(self.motor(now_s)[i]))
        memory[self._present : self._present + self._size] = self._coded(MIDDLE + round(turned * TURN / (2 * np.pi)))
        return self._status_packet(servo, bytes(memory[address : address + length]))

    def _status_packet(self, servo: int, data: bytes) -> bytes:
        error = self._memory[servo][self._status]
        if self._dynamixel:
            packet = b"\xff\xff\xfd\x00" + bytes([servo, len(data) + 4, 0, 0x55, 0x80 if error else 0]) + data
            return packet + _crc(packet).to_bytes(2, "little")
        packet = bytes([servo, len(data) + 2, error]) + data
        return b"\xff\xff" + packet + bytes([0xFF - sum(packet) % 256])

    def _store(self, servo: int, address: int, data: bytes, now_s: float) -> None:
        memory, i = self._memory[servo], self._ids.index(servo)
        if self._dynamixel and address < 64 and memory[self._torque]:
            return  # EEPROM is not written while the torque is on
        memory[address : address + len(data)] = data
        if not memory[self._torque]:
            self._axes[i].halt(now_s)
        elif address <= self._goal < address + len(data):
            self._go(i, memory, now_s)

    def _go(self, i: int, memory: bytearray, now_s: float) -> None:
        shown = int.from_bytes(memory[self._goal : self._goal + self._size], "little", signed=self._dynamixel)
        if not self._dynamixel and shown & 0x8000:
            shown = 0x8000 - shown
        goal, _ = self._within_limits(i, (shown - MIDDLE) * 2 * np.pi / TURN)
        axis = self._axes[i]
        axis.halt(now_s)
        way = abs(goal - axis.goal)
        if way <= np.pi / TURN:  # its resolution is one step
            return
        if self._dynamixel:
            timed = memory[10] & 4
            seconds = int.from_bytes(memory[112:116], "little") / 1000 if timed else 0.0
        else:
            speed = int.from_bytes(memory[46:48], "little") * 2 * np.pi / TURN
            seconds = least_seconds(way, speed) if speed else 0.0
        axis.queue(goal, now_s, max(seconds, least_seconds(way, FASTEST_RAD_S)) if seconds else 0.0)

    def _coded(self, position: int) -> bytes:
        if self._dynamixel:
            return position.to_bytes(4, "little", signed=True)
        return (abs(position) + (0x8000 if position < 0 else 0)).to_bytes(2, "little")


def _crc(data: bytes) -> int:
    """The rest of a long division of bits by the polynomial 18005 hex."""
    rest = int.from_bytes(data + b"\0\0", "big")
    for bit in range(8 * len(data) + 15, 15, -1):
        if rest >> bit & 1:
            rest ^= 0x18005 << bit - 16
    return rest
