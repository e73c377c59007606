"""Motors that take their time: each axis goes through its queue of travels, ramps up and down, and can be stopped."""

from collections import deque
from dataclasses import dataclass
from typing import final

import numpy as np

RAMP = 0.25
"""Share of a travel's time in which it gains speed, and in which it loses it again."""
FASTEST_RAD_S = 1.0
"""Of every axis, at full speed (or m/s)."""


@final
@dataclass(frozen=True)
class Travel:
    """One axis from one angle to another."""

    start: float
    goal: float
    """[rad]"""
    begins_s: float
    seconds: float

    @property
    def ends_s(self) -> float:
        """When it is there."""
        return self.begins_s + self.seconds

    def at(self, now_s: float) -> float:
        """Where it is [rad]."""
        gone = now_s - self.begins_s
        if gone >= self.seconds:
            return self.goal
        return self.start + (self.goal - self.start) * way_gone(max(gone, 0.0) / self.seconds)


def way_gone(share: float) -> float:
    """Share of the way after a share of the time, both 0 to 1: speed is a trapezium."""
    if share > 1 - RAMP:
        return 1 - way_gone(1 - share)
    if share < RAMP:
        return share**2 / (2 * RAMP * (1 - RAMP))
    return (share - RAMP / 2) / (1 - RAMP)


def least_seconds(way_rad: float, fastest_rad_s: float) -> float:
    """How long a travel takes at least if its speed never exceeds the fastest."""
    return abs(way_rad) / (fastest_rad_s * (1 - RAMP))


@final
class Axis:
    """One motor: where it was told to go, and where it is. Time never runs backwards."""

    def __init__(self, angle: float) -> None:
        self._travels = deque([Travel(angle, angle, -np.inf, 0.0)])
        self._jammed: float | None = None

    @property
    def jammed(self) -> bool:
        """Whether it sticks."""
        return self._jammed is not None

    @property
    def goal(self) -> float:
        """Where it will be when it has gone through its queue [rad]."""
        return self._travels[-1].goal

    @property
    def free_s(self) -> float:
        """When it has gone through its queue."""
        return self._travels[-1].ends_s

    def at(self, now_s: float) -> float:
        """Where it is [rad]."""
        return self.travel(now_s).at(now_s) if self._jammed is None else self._jammed

    def travel(self, now_s: float) -> Travel:
        """What it was last told to do, finished or not."""
        while len(self._travels) > 1 and self._travels[1].begins_s <= now_s:
            self._travels.popleft()
        return self._travels[0]

    def queue(self, goal: float, begins_s: float, seconds: float) -> None:
        """Go to an angle after all that it was told before."""
        self._travels.append(Travel(self.goal, goal, begins_s, seconds))

    def halt(self, now_s: float) -> None:
        """Stop here and forget the queue."""
        here = self.travel(now_s).at(now_s)
        self._travels = deque([Travel(here, here, now_s, 0.0)])

    def jam(self, now_s: float) -> None:
        """Stick here, whatever it is told."""
        self._jammed = self.at(now_s)
