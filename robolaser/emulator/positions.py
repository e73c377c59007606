"""The positions that an ACL controller keeps by name, and what it answers about them."""

import re
from enum import Enum
from typing import final

from robolaser.arrays import Ints
from robolaser.emulator.cartesian import NAMES, place
from robolaser.emulator.encoders import Encoders
from robolaser.robot.kinematics import Robot

OK = ["O.K."]
WIDTH = 9
"""Of a number in a listing, with its sign, or a blank for plus."""
BAD_AXIS = ["*** ERROR 310: BAD AXIS"]
BAD_COORDINATE = ["*** ERROR 312: BAD POINT COORDINATE"]


class Missing(Enum):
    """Why there are no counts under a name."""

    UNDEFINED = "*** UNDEFINED POSITION"
    """Nobody defined it."""
    NOT_ASSIGNED = "*** ERROR 303: NO POSITION ASSIGNED"
    """It was defined, and nothing stored in it."""

    def lines(self, rest: list[str]) -> list[str]:
        """The answer to the words after a command."""
        name = rest[:1] if self is Missing.UNDEFINED else []
        return [" ".join([self.value, *name])]


@final
class Positions:
    """Names, defined or with counts; each method takes the words after a command and gives the lines of the answer."""

    def __init__(self, robot: Robot, encoders: Encoders) -> None:
        self._robot = robot
        self._encoders = encoders
        self._kept: dict[str, Ints | None] = {}

    def find(self, rest: list[str]) -> Ints | Missing:
        """The counts of the position that is named first, (j,); or why there are none."""
        if not rest or rest[0] not in self._kept:
            return Missing.UNDEFINED
        counts = self._kept[rest[0]]
        return Missing.NOT_ASSIGNED if counts is None else counts

    def define(self, rest: list[str]) -> list[str]:
        """DEFP name."""
        if len(rest) != 1 or not re.fullmatch(r"[A-Z][A-Z0-9_]*", rest[0]) or rest[0] == "POSITION":
            return BAD_COORDINATE
        if rest[0] in self._kept:
            return [f"*** POSITION {rest[0]} ALREADY DEFINED"]
        self._kept[rest[0]] = None
        return OK

    def forget_all(self) -> None:
        """As after a failure of the power."""
        self._kept.clear()

    def store(self, rest: list[str], counts: Ints) -> list[str]:
        """HERE name."""
        if self.find(rest) is Missing.UNDEFINED:
            return Missing.UNDEFINED.lines(rest)
        self._kept[rest[0]] = counts
        return OK

    def set_counts(self, rest: list[str]) -> list[str]:
        """SETPV name axis counts."""
        stored = self.find(rest)
        if isinstance(stored, Missing):
            return stored.lines(rest)
        axis, counts = (number(word) for word in (*rest[1:3], "", "")[:2])
        if axis is None or not 1 <= axis <= len(stored):
            return BAD_AXIS
        if counts is None or len(rest) != 3:
            return BAD_COORDINATE
        changed = stored.copy()
        changed[axis - 1] = counts
        return self.store(rest, changed)

    def show(self, counts: Ints) -> list[str]:
        """What LISTPV says of counts, (j,)."""
        where = place(self._robot, self._encoders.angles(counts))
        return [
            "".join(f"{i}:{count:<{WIDTH}}" for i, count in enumerate(map(_signed, counts), 1)).rstrip(),
            "".join(f"{name}:{_signed(value):<{WIDTH}}" for name, value in zip(NAMES, where, strict=True)).rstrip(),
        ]


def _signed(value: int) -> str:
    return f"{value: d}"


def number(word: str) -> int | None:
    """A whole number as typed; None: it is none."""
    return int(word) if re.fullmatch(r"[+-]?\d{1,9}", word) else None
