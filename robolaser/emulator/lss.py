"""Servos on one line that speak the Lynxmotion Smart Servo protocol: each hears all, and answers if it is asked."""

import re
from collections.abc import Sequence
from enum import IntEnum
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.controller import ArmFault, Controller
from robolaser.emulator.joints import RAMP, Axis, least_seconds
from robolaser.robot.kinematics import Robot

TENTHS = 1800 / np.pi
"""Of a degree, in a radian."""
FASTEST_RAD_S = 1.0
USUAL_SPEED = 1800
"""Cap on the speed of a servo that was just switched on; it cannot reach it [tenths of a degree/s]."""
ALL = 254
BOOT_S = 1.25
LONGEST_LINE = 64
_COMMAND = re.compile(r"#(\d{1,3})([A-Z]+)(-?\d{1,6})?((?:[A-Z]+-?\d{1,6})*)")
_MODIFIER = re.compile(r"([A-Z]+)(-?\d{1,6})")


class Status(IntEnum):
    """What a servo says that it does."""

    LIMP = 1
    ACCELERATING = 3
    TRAVELLING = 4
    DECELERATING = 5
    HOLDING = 6
    OUTSIDE_LIMITS = 7
    STUCK = 8
    BLOCKED = 9
    SAFE_MODE = 10


@final
class Servo:
    """One servo; it has an absolute encoder, so that it always knows its angle."""

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        self.state = Status.HOLDING
        self.fastest = USUAL_SPEED
        """Cap on its speed [tenths of a degree/s]."""

    def status(self, now_s: float) -> Status:
        """What it does now."""
        travel = self.axis.travel(now_s)
        if self.state is not Status.HOLDING:
            return self.state
        if self.axis.jammed and abs(self.axis.at(now_s) - travel.goal) * TENTHS >= 1:
            return Status.STUCK
        if now_s >= travel.ends_s:
            return Status.HOLDING
        gone = (now_s - travel.begins_s) / travel.seconds
        if gone < RAMP:
            return Status.ACCELERATING
        return Status.DECELERATING if gone > 1 - RAMP else Status.TRAVELLING

    def rest(self, state: Status, now_s: float) -> None:
        """Stop here."""
        self.axis.halt(now_s)
        self.state = state


@final
class LssController(Controller):
    """A chain of servos; nothing comes back but answers."""

    def __init__(
        self, robot: Robot, ids: Sequence[int], reference: Sequence[float], direction: Sequence[float]
    ) -> None:
        j = len(robot.joints)
        self._reference = np.array(reference or [0.0] * j)
        self._direction = np.array(direction or [1.0] * j)
        self._lower, self._upper = robot.lower, robot.upper
        begin = np.clip(self._reference, robot.lower, robot.upper)
        self._servos = [Servo(Axis(float(angle))) for angle in begin]
        self._index = {number: i for i, number in enumerate(ids or range(1, j + 1))}
        self._line = bytearray()
        self._awake_s = -np.inf

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Take commands and answer questions."""
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

    def poll(self, now_s: float) -> bytes:
        """Nothing: servos answer only when they are asked."""
        return b""

    def motor(self, now_s: float) -> Array:
        """Joint angles as the encoders see them, (j,) [rad]."""
        return np.array([servo.axis.at(now_s) for servo in self._servos])

    def outputs(self, now_s: float) -> frozenset[int]:
        """None: servos have no outputs."""
        return frozenset()

    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Bear what befalls the arm; servos have no home to miss."""
        servo = self._servos[axis - 1]
        if fault is ArmFault.IMPACT:
            servo.rest(Status.BLOCKED, now_s)
        elif fault is ArmFault.STALL:
            servo.axis.jam(now_s)
        elif fault is ArmFault.THERMIC:
            servo.rest(Status.SAFE_MODE, now_s)
        elif fault is ArmFault.REBOOT:
            for one in self._servos:
                self._reset(one, now_s)

    def _take(self, line: str, now_s: float) -> bytes:
        said = _COMMAND.fullmatch(line)
        if said is None or now_s < self._awake_s:
            return b""
        number, word = int(said[1]), said[2]
        value = None if said[3] is None else int(said[3])
        if number == ALL:
            for each in self._index:
                self._do(each, word, value, dict(_MODIFIER.findall(said[4])), now_s)
            return b""
        if number not in self._index:
            return b""
        if word.startswith("Q") and value is None:
            answer = self._answer(number, word, now_s)
            return b"" if answer is None else f"*{number}{word}{answer}\r".encode()
        self._do(number, word, value, dict(_MODIFIER.findall(said[4])), now_s)
        return b""

    def _answer(self, number: int, word: str, now_s: float) -> int | None:
        servo = self._servos[self._index[number]]
        if word == "Q":
            return int(servo.status(now_s))
        if word == "QD":
            return self._shown(number, servo.axis.at(now_s))
        if word == "QDT":
            return self._shown(number, servo.axis.goal)
        if word == "QSD":
            return servo.fastest
        usual = {"QV": 11200, "QT": 310, "QC": 140, "QID": number}
        return usual.get(word)

    def _do(self, number: int, word: str, value: int | None, modifiers: dict[str, str], now_s: float) -> None:
        servo = self._servos[self._index[number]]
        if word == "RESET":
            self._reset(servo, now_s)
        elif servo.state is Status.SAFE_MODE:
            return
        elif word in ("H", "L"):
            servo.rest(Status.HOLDING if word == "H" else Status.LIMP, now_s)
        elif word == "SD" and value is not None and value > 0:
            servo.fastest = value
        elif word in ("D", "MD") and value is not None:
            shown = value + (self._shown(number, servo.axis.at(now_s)) if word == "MD" else 0)
            self._go(number, shown, modifiers, now_s)

    def _go(self, number: int, shown: int, modifiers: dict[str, str], now_s: float) -> None:
        i = self._index[number]
        servo = self._servos[i]
        wanted = self._reference[i] + self._direction[i] * shown / TENTHS
        goal = float(np.clip(wanted, self._lower[i], self._upper[i]))
        servo.rest(Status.HOLDING if abs(goal - wanted) * TENTHS < 1 else Status.OUTSIDE_LIMITS, now_s)
        way = goal - servo.axis.goal
        seconds = max(least_seconds(way, FASTEST_RAD_S), least_seconds(way, servo.fastest / TENTHS))
        if int(modifiers.get("SD", 0)) > 0:
            seconds = max(seconds, least_seconds(way, int(modifiers["SD"]) / TENTHS))
        servo.axis.queue(goal, now_s, max(seconds, int(modifiers.get("T", 0)) / 1000))

    def _shown(self, number: int, angle: float) -> int:
        i = self._index[number]
        return round(float(self._direction[i] * (angle - self._reference[i]) * TENTHS))

    def _reset(self, servo: Servo, now_s: float) -> None:
        servo.rest(Status.LIMP, now_s)
        servo.fastest = USUAL_SPEED
        self._awake_s = now_s + BOOT_S
