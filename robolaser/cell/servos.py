"""Arms of bus servos that share a line: Dynamixel's X series, and Feetech's STS series.

A register is an address and a number of bytes; addresses and lengths are written in `wide` bytes, the lowest first.
`torque`: whether the motor holds; `goal`: its goal; `motion`: the goal and its profile, in one piece; `present`: its
position; `status`: bits of `trouble`; `drive_mode`: the profile's units, if there is a choice.

Dynamixel: ROBOTIS e-Manual, DYNAMIXEL Protocol 2.0 and X series. Feetech: SMS and STS protocol manual, STS3215; a
descendant of Dynamixel's first protocol.
"""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.failures import AnswerUnclear, alarm, line_lost, unclear
from robolaser.cell.serial_line import LETTERS, BusArm, SerialLine
from robolaser.data.cell_config import ArmLine
from robolaser.errors import ArmError
from robolaser.robot.kinematics import Robot

READ_ALL, WRITE_ALL = 0x82, 0x83  # SYNC READ, which each servo answers in turn, and SYNC WRITE, which none answers
EVERYBODY = 0xFE
CRC_POLYNOMIAL = 0x8005
RAMP = 0.25  # share of a motion's time in which it gains speed
STEEPEST = 254  # acceleration of Feetech's servos at most [100 steps/s2]
BRAKING = 100, STEEPEST  # speed [steps/s] and acceleration [100 steps/s2] with which Feetech's servos stop
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
        """A pattern of a servo's answer: instruction 55 hex, an error, the data."""
        head = b"\xff\xff\xfd\0" + bytes([servo]) + (length + 4).to_bytes(2, "little") + b"\x55"
        return re.escape(head) + b"[\0-\xff](?P<data>[\0-\xff]{%d})[\0-\xff]{2}" % length

    def is_whole(self, packet: bytes) -> bool:
        """Whether the CRC is right."""
        return crc16(packet[:-2]) == int.from_bytes(packet[-2:], "little")

    def motion_data(self, way: int, goal: int, seconds: float) -> bytes:
        """Times of ramp and motion [ms], and the goal [steps]; 0 s: stop."""
        times = round(1000 * RAMP * seconds), round(1000 * seconds), goal
        return b"".join(number.to_bytes(4, "little", signed=True) for number in times)

    def setpoint(self, goal: int) -> bytes:
        """Motion to a goal without a ramp: times of 0."""
        return self.motion_data(0, goal, 0.0)

    def positions(self, raw: Ints, length: int) -> Ints:
        """Positions from registers of so many bytes, (j,) [steps]: two's complement."""
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
        """A pattern of a servo's answer: an error, the data."""
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
        """Motion to a goal without a ramp: the highest acceleration; a speed of 0 is no limit."""
        return bytes([STEEPEST]) + _signed(goal) + b"\0\0\0\0"

    def positions(self, raw: Ints, length: int) -> Ints:
        """Positions from registers of so many bytes, (j,) [steps]: the highest bit is the sign."""
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
MIDDLE = 2048
QUIET_S = 0.25
TRIES = 4
SAGGED = 20  # steps by which the goal of a motor without torque may be off: in some it follows the position
TIMED = 4  # bit of Dynamixel's drive mode: profiles in times
ADVICE = "Free the arm, let it cool down, check its supply, and switch its power off and on."


@final
class ServoArm(BusArm):
    """Servos with absolute encoders; their torque is off until the first motion, so that they can be moved by hand.

    angle = reference_rad + direction (position - 2048) 2 pi / 4096.
    """

    synchronous_read: ClassVar[bool] = True
    follows: ClassVar[bool] = True
    counted_rad: ClassVar[float] = 2 * np.pi / 4096
    most: ClassVar[int] = 252

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        super().__init__(line, arm, robot)
        self._protocol = SERVOS[arm.kind]
        if self._protocol.drive_mode is not None:
            self._state_times(self._protocol.drive_mode)
        self.read()

    def read(self) -> Array:
        """Read the joint angles, (j,)."""
        return self._angles(self._positions(self._protocol.present) - MIDDLE)

    def poll_faults(self) -> None:
        """Raise the fault that a joint reports."""
        for joint, bits in zip(self._joints, self._numbers(self._protocol.status), strict=True):
            if bits:
                what = ", ".join(text for bit, text in self._protocol.trouble.items() if bits & bit) or f"error {bits}"
                raise alarm(self._line.port, joint, what, ADVICE)

    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,), of all servos at once."""
        goal = MIDDLE + self._counts(q)
        start = self._positions(self._protocol.present)
        if not all(self._numbers(self._protocol.torque)):
            # with torque on, a motor moves to its stored goal
            self._send_checked(start, start, seconds, slack=SAGGED)
            self._write(self._protocol.torque, [b"\1"] * len(self._ids))
        self._send_checked(start, goal, seconds)

    def follow(self, q: Array) -> None:
        """Send all servos to angles, (j,), as fast as their loops can; the next call replaces a lost packet."""
        goal = (MIDDLE + self._counts(q)).tolist()
        self._write(self._protocol.motion, [self._protocol.setpoint(each) for each in goal])

    def stop(self) -> None:
        """Stop by a motion to the current position: these servos have no other stop command."""
        if not any(self._numbers(self._protocol.torque)):
            return
        for _ in range(TRIES):
            at = self._positions(self._protocol.present)
            self._send_on(at, at, 0.0)
            heard = self._positions(self._protocol.goal)
            if (heard == at).all():
                return
        raise unclear(self._line.port, f"stop at {at.tolist()}", str(heard.tolist()), TRIES)

    def _state_times(self, drive_mode: Register) -> None:
        """Set Dynamixels to profiles in times, a setting that they keep when switched off."""
        modes = self._numbers(drive_mode)
        if all(mode & TIMED for mode in modes):
            return
        if any(self._numbers(self._protocol.torque)):
            raise ArmError(
                f"The servos on {self._line.port} have their torque on, and the drive mode that lets motions be given a"
                " time (bit 2) can only be set with torque off. Support the arm, switch their power off and on, and try"
                " again."
            )
        self._write(drive_mode, [bytes([mode | TIMED]) for mode in modes])

    def _send_checked(self, start: Ints, goal: Ints, seconds: float, *, slack: int = 0) -> None:
        """Send all servos on, as `_send_on`, until each reads back its goal: they confirm nothing by themselves."""
        for _ in range(TRIES):
            self._send_on(start, goal, seconds)
            heard = self._positions(self._protocol.goal)
            if (np.abs(heard - goal) <= slack).all():
                return
        with suppress(AnswerUnclear):
            self.stop()
        self.poll_faults()
        raise unclear(self._line.port, f"goal {goal.tolist()}", str(heard.tolist()), TRIES)

    def _send_on(self, start: Ints, goal: Ints, seconds: float) -> None:
        """Move all servos from start to goal, (j,) each, with the same ramps; 0 s: stop."""
        ways = zip(np.abs(goal - start).tolist(), goal.tolist(), strict=True)
        self._write(
            self._protocol.motion, [self._protocol.motion_data(way, position, seconds) for way, position in ways]
        )

    def _positions(self, register: Register) -> Ints:
        """Positions of all servos, (j,) [steps]."""
        return self._protocol.positions(np.array(self._numbers(register), dtype=np.int64), register[1])

    def _numbers(self, register: Register) -> list[int]:
        """The register's value in all servos, without its sign."""
        address, length = register
        parameters = b"".join(number.to_bytes(self._protocol.wide, "little") for number in register) + bytes(self._ids)
        heard = ""
        for _ in range(TRIES):
            heard += self._line.discard()
            self._line.send(self._protocol.instruction(READ_ALL, parameters).decode(LETTERS))
            found = []
            for servo in self._ids:
                pattern = re.compile(self._protocol.answer(servo, length).decode(LETTERS))
                text, answer = self._line.until(pattern, QUIET_S)
                heard += text
                if answer is None or not self._protocol.is_whole(answer[0].encode(LETTERS)):
                    break
                found.append(int.from_bytes(answer["data"].encode(LETTERS), "little"))
            if len(found) == len(self._ids):
                return found
        servo = self._ids[len(found)]
        if not heard:
            raise line_lost(self._line.port, f"servo {servo} ({self._joints[len(found)]}) gave no answer")
        raise unclear(self._line.port, f"read {address} of servo {servo}", heard, TRIES)

    def _write(self, register: Register, data: Sequence[bytes]) -> None:
        parameters = b"".join(number.to_bytes(self._protocol.wide, "little") for number in register)
        parameters += b"".join(bytes([servo]) + one for servo, one in zip(self._ids, data, strict=True))
        self._line.send(self._protocol.instruction(WRITE_ALL, parameters).decode(LETTERS))
