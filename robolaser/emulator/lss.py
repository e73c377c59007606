"""Servos on one line with the Lynxmotion Smart Servo protocol: each receives all commands, and answers requests."""

import re
from enum import IntEnum
from typing import final

import numpy as np

from robolaser.data.cell_config import Cell
from robolaser.emulator.controller import FASTEST_RAD_S, ArmFault, Axis, ServoChain, least_seconds

TENTHS = 1800 / np.pi  # of a degree, in a radian
USUAL_SPEED = 1800  # speed limit after switching on, which it cannot reach [tenths of a degree/s]
ALL = 254
BOOT_S = 1.25
LONGEST_LINE = 64
_COMMAND = re.compile(r"#(?P<id>\d{1,3})(?P<word>[A-Z]+)(?P<value>-?\d{1,6})?(?:T(?P<time>\d{1,6}))?")


class Status(IntEnum):
    """State that a servo reports."""

    LIMP = 1
    TRAVELLING = 4
    HOLDING = 6
    OUTSIDE_LIMITS = 7
    STUCK = 8
    BLOCKED = 9
    SAFE_MODE = 10


@final
class LssServo:
    """One servo with an absolute encoder."""

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        self.state = Status.HOLDING
        self.fastest = USUAL_SPEED  # cap on its speed [tenths of a degree/s]

    def status(self, now_s: float) -> Status:
        """Its current state."""
        travel = self.axis.travel(now_s)
        if self.state is not Status.HOLDING:
            return self.state
        if self.axis.jammed and abs(self.axis.at(now_s) - travel.goal) * TENTHS >= 1:
            return Status.STUCK
        return Status.HOLDING if now_s >= travel.ends_s else Status.TRAVELLING

    def rest(self, state: Status, now_s: float) -> None:
        """Stop here."""
        self.axis.halt(now_s)
        self.state = state


@final
class LssController(ServoChain):
    """A chain of servos; they send answers only."""

    def __init__(self, cell: Cell) -> None:
        super().__init__(cell)
        self._servos = {number: LssServo(axis) for number, axis in zip(self._ids, self._axes, strict=True)}
        self._line = bytearray()
        self._awake_s = -np.inf

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Receive commands and answer requests."""
        answers = b""
        for byte in data:
            if byte == ord("\r"):
                line = self._line.decode("ascii", errors="replace").upper()
                self._line.clear()
                answers += self._take(line, now_s)
            elif byte == ord("#"):
                self._line = bytearray(b"#")
            elif len(self._line) < LONGEST_LINE:
                self._line.append(byte)
        return answers

    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Cause a fault; servos have no homing."""
        servo = self._servos[self._ids[axis - 1]]
        if fault is ArmFault.IMPACT:
            servo.rest(Status.BLOCKED, now_s)
        elif fault is ArmFault.STALL:
            servo.axis.jam(now_s)
        elif fault is ArmFault.THERMIC:
            servo.rest(Status.SAFE_MODE, now_s)
        elif fault is ArmFault.REBOOT:
            for each in self._servos.values():
                each.rest(Status.LIMP, now_s)
                each.fastest = USUAL_SPEED
            self._awake_s = now_s + BOOT_S

    def _take(self, line: str, now_s: float) -> bytes:
        match = _COMMAND.fullmatch(line)
        if match is None or now_s < self._awake_s:
            return b""
        number, word, value = int(match["id"]), match["word"], match["value"]
        if number in self._servos and word.startswith("Q") and value is None:
            answer = self._answer(number, word, now_s)
            return b"" if answer is None else f"*{number}{word}{answer}\r".encode()
        for each in self._ids if number == ALL else [number]:
            if each in self._servos and self._servos[each].state is not Status.SAFE_MODE:
                self._do(each, word, None if value is None else int(value), int(match["time"] or 0), now_s)
        return b""

    def _answer(self, number: int, word: str, now_s: float) -> int | None:
        servo = self._servos[number]
        if word == "Q":
            return int(servo.status(now_s))
        if word == "QSD":
            return servo.fastest
        angles = {"QD": servo.axis.at(now_s), "QDT": servo.axis.goal}
        return round(self._turned(self._ids.index(number), angles[word]) * TENTHS) if word in angles else None

    def _do(self, number: int, word: str, value: int | None, time_ms: int, now_s: float) -> None:
        servo = self._servos[number]
        if word == "H":
            servo.rest(Status.HOLDING, now_s)
        elif word == "SD" and value:
            servo.fastest = max(value, 1)
        elif word == "D" and value is not None:
            goal, beyond = self._within_limits(self._ids.index(number), value / TENTHS)
            servo.rest(Status.HOLDING if beyond * TENTHS < 1 else Status.OUTSIDE_LIMITS, now_s)
            way = goal - servo.axis.goal
            fastest = min(FASTEST_RAD_S, servo.fastest / TENTHS)
            servo.axis.queue(goal, now_s, max(least_seconds(way, fastest), time_ms / 1000))
