"""The controller of a SCORBOT: a terminal that speaks ACL, with a prompt, stored positions and a queue of movements.

After the reference guide of ACL for Controller-A (Eshed Robotec); it knows the commands that our driver sends.
"""

import re
from collections.abc import Callable
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.cell_config import Cell
from robolaser.emulator.acl_encoders import AclEncoders
from robolaser.emulator.controller import FASTEST_RAD_S, ArmFault, Axis, Controller, least_seconds

SEARCH_S, SEARCH_RAD_S = 20.0, 0.3  # least duration and highest speed of homing an axis
OUTPUTS = range(1, 17)
LONGEST_LINE = 128
ABORT, ENTER, NEWLINE = 0x01, 0x0D, 0x0A
PROMPT = b">"
BOOT = (  # printed after a restart with lost memory
    "----RAM TEST COMPLETE.",
    "",
    "----ROM TEST COMPLETE.",
    "",
    "USER RAM CHECKPOINT ERROR !",
    "INSTALLING DEFAULT SETUP.",
    "SYSTEM READY !",
)
OK = ("O.K.",)


class Refusal(Exception):
    """A command that cannot be executed, in the controller's words."""


UNRECOGNIZED = "UNRECOGNIZED REQUEST"
BAD_AXIS = "ERROR 310: BAD AXIS"
BAD_COORDINATE = "ERROR 312: BAD POINT COORDINATE"


@final
class AclController(Controller):
    """One terminal, one group of axes; homed, motors on, at home when it begins."""

    def __init__(self, cell: Cell) -> None:
        self._encoders = AclEncoders(cell)
        self._axes = [Axis(float(angle)) for angle in self._encoders.home]
        self._positions: dict[str, Ints | None] = {}
        self._disabled: set[int] = set()
        self._outputs: set[int] = set()
        self._homing: tuple[float, int] | None = None  # when it ends, and the axis that does not find its home, or 0
        self._homeless: set[int] = set()
        self._line = bytearray()
        self._echo = True
        self._unsent = b""
        self._words: dict[str, Callable[[list[str], float], tuple[str, ...]]] = {
            "LISTPV": self._listpv,
            "SHOW": self._show,
            "DEFP": self._defp,
            "HERE": self._here,
            "SETPV": self._setpv,
            "MOVE": self._move,
            "SPEED": lambda rest, now_s: OK,  # only for movements without a time
            "HOME": self._home,
            "SET": self._set,
            "CON": self._con,
            "ECHO": self._echo_on,
        }

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Receive characters, echo them, and answer each line."""
        return b"".join(self._take(byte, now_s) for byte in data)

    def poll(self, now_s: float) -> bytes:
        """Return the end of homing, and the *** lines."""
        if self._homing is not None and now_s >= self._homing[0]:
            missed = self._homing[1]
            self._unsent += _lines(f"*** HOME FAILURE AXIS {missed}" if missed else "HOMING COMPLETE (ROBOT)")
            if not missed:
                self._encoders.find_home()
            self._homing = None
        reports, self._unsent = self._unsent, b""
        return reports

    def outputs(self, now_s: float) -> frozenset[int]:
        """The digital outputs that are on."""
        return frozenset(self._outputs)

    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Cause a fault."""
        if fault is ArmFault.STALL:
            self._axes[axis - 1].jam(now_s)
        elif fault is ArmFault.HOMELESS:
            self._homeless.add(axis)
        elif fault is ArmFault.REBOOT:
            self._reboot(now_s)
        else:
            self._give_up("IMPACT PROTECTION" if fault is ArmFault.IMPACT else "THERMIC OVERLOAD", axis, now_s)

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
        if len(self._line) < LONGEST_LINE:
            self._line.append(byte)
        return echo

    def _answer(self, line: str, now_s: float) -> bytes:
        word, *rest = line.upper().split() or [""]
        try:
            if word and word not in self._words:
                raise Refusal(UNRECOGNIZED)
            lines = self._words[word](rest, now_s) if word else ()
        except Refusal as refusal:
            lines = (f"*** {refusal}",)
        except (ValueError, IndexError, OverflowError):
            lines = (f"*** {BAD_COORDINATE}",)
        return _lines(*lines) + PROMPT

    def _listpv(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        here = rest == ["POSITION"]
        return self._encoders.listed(self._encoders.counts(self.motor(now_s)) if here else self._stored(rest))

    def _show(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        if rest[0] != "PAR":
            raise Refusal(UNRECOGNIZED)
        return (f"PAR {int(rest[1])}={self._encoders.par.get(int(rest[1]), 0)}", *OK)

    def _defp(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        (name,) = rest
        if name in self._positions:
            raise Refusal(f"POSITION {name} ALREADY DEFINED")
        self._positions[name] = None
        return OK

    def _here(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        self._positions[self._defined(rest)] = self._encoders.counts(self.motor(now_s))
        return OK

    def _setpv(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        changed = self._stored(rest).copy()
        name, axis, counts = rest
        if not 1 <= int(axis) <= len(changed):
            raise Refusal(BAD_AXIS)
        changed[int(axis) - 1] = int(counts)
        self._positions[name] = changed
        return OK

    def _move(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        counts = self._stored(rest)
        seconds = int(rest[1]) / 100 if len(rest) > 1 else 0.0
        self._check_ready()
        goal = self._encoders.angles(counts)
        outside = self._encoders.outside(goal)
        if outside:
            self._give_up("OUT OF RANGE", outside[0], now_s)
            return ()
        self._go(goal, seconds, now_s)
        return OK

    def _home(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        """Queue the search of one axis after the other."""
        self._check_ready()
        self._stop(now_s)
        ends_s, missed = now_s, 0
        for number, (axis, home) in enumerate(zip(self._axes, self._encoders.home, strict=True), 1):
            search_s = max(SEARCH_S, least_seconds(home - axis.goal, SEARCH_RAD_S))
            axis.queue(float(home), ends_s, search_s)
            ends_s += search_s
            if number in self._homeless or axis.jammed:
                missed = number
                break
        self._homing = ends_s, missed
        return ("WAIT!! HOMING...",)

    def _set(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        match = re.fullmatch(r"OUT\[(\d{1,9})\]=([01])", "".join(rest))
        if match is None:
            raise Refusal(UNRECOGNIZED)
        output = int(match[1])
        if output not in OUTPUTS:
            raise Refusal(f"BAD OUTPUT {output}")
        (self._outputs.add if match[2] == "1" else self._outputs.discard)(output)
        return OK

    def _con(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        self._disabled = set()
        return OK

    def _echo_on(self, rest: list[str], now_s: float) -> tuple[str, ...]:
        self._echo = True
        return OK

    def _defined(self, rest: list[str]) -> str:
        """The name of the position that is named first."""
        if not rest or rest[0] not in self._positions:
            raise Refusal(" ".join(["UNDEFINED POSITION", *rest[:1]]))
        return rest[0]

    def _stored(self, rest: list[str]) -> Ints:
        """The counts of the first position in a command, (j,)."""
        counts = self._positions[self._defined(rest)]
        if counts is None:
            raise Refusal("ERROR 303: NO POSITION ASSIGNED")
        return counts

    def _check_ready(self) -> None:
        if self._disabled:
            raise Refusal(f"ERROR 304: AXIS DISABLED {min(self._disabled)}")
        if self._homing is not None:
            raise Refusal("HOMING IN PROGRESS")

    def _go(self, goal: Array, seconds: float, now_s: float) -> None:
        """Queue a movement, in the requested time but within the axes' speed."""
        way = float(np.abs(goal - [axis.goal for axis in self._axes]).max())
        seconds = max(seconds, least_seconds(way, FASTEST_RAD_S))
        begins_s = max(now_s, self._axes[0].free_s)  # all axes process their queues together, after homing
        for axis, angle in zip(self._axes, goal, strict=True):
            axis.queue(float(angle), begins_s, seconds)

    def _stop(self, now_s: float) -> None:
        self._homing = None
        for axis in self._axes:
            axis.halt(now_s)

    def _give_up(self, reason: str, axis: int, now_s: float) -> None:
        self._stop(now_s)
        self._disabled.add(axis)
        self._unsent += _lines(f"*** {reason} axis {axis}")

    def _reboot(self, now_s: float) -> None:
        self._stop(now_s)
        self._encoders.lose(self.motor(now_s))
        self._positions.clear()
        self._outputs.clear()
        self._unsent = _lines(*BOOT) + PROMPT
        self._line.clear()
        self._echo = True
        self._disabled = set()


def _lines(*lines: str) -> bytes:
    return b"\r\n" + b"".join(line.encode() + b"\r\n" for line in lines)
