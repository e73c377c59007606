"""The controller of a SCORBOT: a terminal that speaks ACL, with a prompt, stored positions and a queue of movements.

After the reference guide of ACL for Controller-A (Eshed Robotec).
"""

import re
from collections.abc import Callable
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.emulator.controller import ArmFault, Controller
from robolaser.emulator.encoders import Encoders
from robolaser.emulator.homing import Homing
from robolaser.emulator.joints import Axis, angles, least_seconds, rest_s
from robolaser.emulator.positions import BAD_COORDINATE, OK, Missing, Positions, number
from robolaser.robot.kinematics import Robot

FASTEST_RAD_S = 1.0
"""Of every axis, at speed 100 (or m/s)."""
OUTPUTS = range(1, 17)
LONGEST_LINE = 128
ABORT, BACKSPACE, ENTER, NEWLINE = 0x01, 0x08, 0x0D, 0x0A
PROMPT = b">"
BOOT = [
    "----RAM TEST COMPLETE.",
    "",
    "----ROM TEST COMPLETE.",
    "",
    "USER RAM CHECKPOINT ERROR !",
    "INSTALLING DEFAULT SETUP.",
    "SYSTEM READY !",
]
"""What a controller prints that lost what its battery kept."""
UNKNOWN = ["*** UNRECOGNIZED REQUEST"]


@final
class AclController(Controller):
    """One terminal, one group of axes; homed, motors on, at home when it begins."""

    def __init__(self, robot: Robot, encoders: Encoders) -> None:
        self._encoders = encoders
        self._axes = [Axis(float(angle)) for angle in encoders.home]
        self._positions = Positions(robot, encoders)
        self._disabled: set[int] = set()
        self._outputs: set[int] = set()
        self._homing: Homing | None = None
        self._homeless: set[int] = set()
        self._speed = 50
        self._line = bytearray()
        self._echo = True
        self._unsaid = b""
        self._words: dict[str, Callable[[list[str], float], list[str]]] = {
            "LISTPV": self._listpv,
            "SHOW": self._show,
            "DEFP": self._defp,
            "HERE": self._here,
            "SETPV": self._setpv,
            "MOVE": self._move,
            "SPEED": self._set_speed,
            "HOME": self._home,
            "SET": self._set,
            "CON": self._con,
            "COFF": self._coff,
            "ECHO": self._echo_on,
            "NOECHO": self._echo_off,
        }

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Take keys, echo them, and answer each line."""
        return b"".join(self._take(byte, now_s) for byte in data)

    def poll(self, now_s: float) -> bytes:
        """Homing that is over, and the *** lines."""
        if self._homing is not None and now_s >= self._homing.ends_s:
            self._unsaid += _lines([self._homing.outcome])
            if self._homing.found:
                self._encoders.find_home()
            self._homing = None
        said, self._unsaid = self._unsaid, b""
        return said

    def motor(self, now_s: float) -> Array:
        """Joint angles as the encoders see them, (j,) [rad] or [m]."""
        return angles(self._axes, now_s)

    def outputs(self, now_s: float) -> frozenset[int]:
        """The digital outputs that are on."""
        return frozenset(self._outputs)

    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Bear what befalls the arm."""
        if fault is ArmFault.STALL:
            self._axes[axis - 1].jam(now_s)
        elif fault is ArmFault.HOMELESS:
            self._homeless.add(axis)
        elif fault is ArmFault.REBOOT:
            self._reboot(now_s)
        else:
            what = "IMPACT PROTECTION" if fault is ArmFault.IMPACT else "THERMIC OVERLOAD"
            self._give_up(f"*** {what} axis {axis}", axis, now_s)

    def _take(self, byte: int, now_s: float) -> bytes:
        if byte == ABORT:
            self._line.clear()
            self._stop(now_s)
            return b"\r\n" + PROMPT
        if byte == NEWLINE:
            return b""
        echo = bytes([byte]) if self._echo else b""
        if byte == ENTER:
            line = self._line.decode("ascii", errors="replace")
            self._line.clear()
            return echo + self._answer(line, now_s)
        if byte == BACKSPACE:
            del self._line[-1:]
        elif len(self._line) < LONGEST_LINE:
            self._line.append(byte)
        return echo

    def _answer(self, line: str, now_s: float) -> bytes:
        word, *rest = line.upper().split() or [""]
        if not word:
            lines = []
        elif word in self._words:
            lines = self._words[word](rest, now_s)
        else:
            lines = UNKNOWN
        return _lines(lines) + PROMPT

    def _listpv(self, rest: list[str], now_s: float) -> list[str]:
        found = self._counts(now_s) if rest == ["POSITION"] else self._positions.find(rest)
        return found.lines(rest) if isinstance(found, Missing) else self._positions.show(found)

    def _show(self, rest: list[str], now_s: float) -> list[str]:
        which = number(rest[1]) if len(rest) == 2 and rest[0] == "PAR" else None
        return UNKNOWN if which is None else [f"PAR {which}={self._encoders.par.get(which, 0)}", *OK]

    def _defp(self, rest: list[str], now_s: float) -> list[str]:
        return self._positions.define(rest)

    def _here(self, rest: list[str], now_s: float) -> list[str]:
        return self._positions.store(rest, self._counts(now_s))

    def _setpv(self, rest: list[str], now_s: float) -> list[str]:
        return self._positions.set_counts(rest)

    def _move(self, rest: list[str], now_s: float) -> list[str]:
        counts = self._positions.find(rest)
        if isinstance(counts, Missing):
            return counts.lines(rest)
        hundredths = number(rest[1]) if len(rest) == 2 else 0
        if hundredths is None or hundredths < 0 or len(rest) > 2:
            return BAD_COORDINATE
        if self._disabled or self._homing is not None:
            return self._unable()
        goal = self._encoders.angles(counts)
        outside = self._encoders.outside(goal)
        if outside:
            self._give_up(f"*** OUT OF RANGE axis {outside[0]}", outside[0], now_s)
            return []
        self._go(goal, hundredths / 100, now_s)
        return OK

    def _set_speed(self, rest: list[str], now_s: float) -> list[str]:
        speed = number(rest[0]) if len(rest) == 1 else None
        if speed is None or not 1 <= speed <= 100:
            return BAD_COORDINATE
        self._speed = speed
        return OK

    def _home(self, rest: list[str], now_s: float) -> list[str]:
        if self._disabled or self._homing is not None:
            return self._unable()
        self._stop(now_s)
        self._homing = Homing(self._axes, self._encoders, frozenset(self._homeless), now_s)
        return ["WAIT!! HOMING..."]

    def _unable(self) -> list[str]:
        return [f"*** ERROR 304: AXIS DISABLED {min(self._disabled)}" if self._disabled else "*** HOMING IN PROGRESS"]

    def _set(self, rest: list[str], now_s: float) -> list[str]:
        said = re.fullmatch(r"OUT\[(\d{1,9})\]=([01])", "".join(rest))
        if said is None:
            return UNKNOWN
        output = int(said[1])
        if output not in OUTPUTS:
            return [f"*** BAD OUTPUT {output}"]
        (self._outputs.add if said[2] == "1" else self._outputs.discard)(output)
        return OK

    def _con(self, rest: list[str], now_s: float) -> list[str]:
        self._disabled = set()
        return OK

    def _coff(self, rest: list[str], now_s: float) -> list[str]:
        self._stop(now_s)
        self._disabled = set(range(1, len(self._axes) + 1))
        return OK

    def _echo_on(self, rest: list[str], now_s: float) -> list[str]:
        self._echo = True
        return OK

    def _echo_off(self, rest: list[str], now_s: float) -> list[str]:
        self._echo = False
        return OK

    def _counts(self, now_s: float) -> Ints:
        return self._encoders.counts(self.motor(now_s))

    def _go(self, goal: Array, seconds: float, now_s: float) -> None:
        """Queue a movement, in the time asked for or, for 0, at the speed set, but never faster than the axes can."""
        way = float(np.abs(goal - [axis.goal for axis in self._axes]).max())
        share = 1.0 if seconds else self._speed / 100
        seconds = max(seconds, least_seconds(way, FASTEST_RAD_S * share))
        begins_s = max(now_s, rest_s(self._axes))
        for axis, angle in zip(self._axes, goal, strict=True):
            axis.queue(float(angle), begins_s, seconds)

    def _stop(self, now_s: float) -> None:
        self._homing = None
        for axis in self._axes:
            axis.halt(now_s)

    def _give_up(self, line: str, axis: int, now_s: float) -> None:
        self._stop(now_s)
        self._disabled.add(axis)
        self._unsaid += _lines([line])

    def _reboot(self, now_s: float) -> None:
        self._stop(now_s)
        self._encoders.lose(self.motor(now_s))
        self._positions.forget_all()
        self._outputs.clear()
        self._unsaid = _lines(BOOT) + PROMPT
        self._line.clear()
        self._echo, self._speed = True, 50
        self._disabled = set()


def _lines(lines: list[str]) -> bytes:
    return b"\r\n" + b"".join(line.encode() + b"\r\n" for line in lines)
