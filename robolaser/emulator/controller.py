"""An arm's controller: it receives bytes, answers, reports by itself, and moves motors in time.

Each axis processes its queue of travels, ramps up and down, and can be stopped.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import Cell

RAMP = 0.25  # share of a travel's time for acceleration, and for deceleration
FASTEST_RAD_S = 1.0  # of every axis, at full speed (or m/s)


@final
@dataclass(frozen=True)
class Travel:
    """One axis from one angle to another."""

    start: float
    goal: float  # [rad]
    begins_s: float
    seconds: float

    @property
    def ends_s(self) -> float:
        """When it ends."""
        return self.begins_s + self.seconds

    def at(self, now_s: float) -> float:
        """Its current angle [rad]."""
        gone = now_s - self.begins_s
        if gone >= self.seconds:
            return self.goal
        return self.start + (self.goal - self.start) * way_gone(max(gone, 0.0) / self.seconds)


def way_gone(share: float) -> float:
    """Share of the way by share of the time, both 0 to 1: the speed profile is a trapezium."""
    if share > 1 - RAMP:
        return 1 - way_gone(1 - share)
    if share < RAMP:
        return share**2 / (2 * RAMP * (1 - RAMP))
    return (share - RAMP / 2) / (1 - RAMP)


def least_seconds(way_rad: float, fastest_rad_s: float) -> float:
    """Least duration of a travel within a speed."""
    return abs(way_rad) / (fastest_rad_s * (1 - RAMP))


@final
class Axis:
    """One motor: its commands and its angle. Time never runs backwards."""

    def __init__(self, angle: float) -> None:
        self._travels = deque([Travel(angle, angle, -np.inf, 0.0)])
        self._jammed: float | None = None

    @property
    def jammed(self) -> bool:
        """Whether it is blocked."""
        return self._jammed is not None

    @property
    def goal(self) -> float:
        """Its angle at the end of its queue [rad]."""
        return self._travels[-1].goal

    @property
    def free_s(self) -> float:
        """When its queue ends."""
        return self._travels[-1].ends_s

    def at(self, now_s: float) -> float:
        """Its current angle [rad]."""
        return self.travel(now_s).at(now_s) if self._jammed is None else self._jammed

    def travel(self, now_s: float) -> Travel:
        """Its current or last travel."""
        while len(self._travels) > 1 and self._travels[1].begins_s <= now_s:
            self._travels.popleft()
        return self._travels[0]

    def queue(self, goal: float, begins_s: float, seconds: float) -> None:
        """Go to an angle after all queued travels."""
        self._travels.append(Travel(self.goal, goal, begins_s, seconds))

    def halt(self, now_s: float) -> None:
        """Stop here and clear the queue."""
        here = self.travel(now_s).at(now_s)
        self._travels = deque([Travel(here, here, now_s, 0.0)])

    def jam(self, now_s: float) -> None:
        """Block here, whatever the commands."""
        self._jammed = self.at(now_s)


class ArmFault(Enum):
    """Faults of an arm."""

    IMPACT = "impact"  # a link hits something: the controller detects it and switches the motors off
    STALL = "stall"  # a gear jams: the motor stops, whatever the commands
    THERMIC = "thermic"  # a motor is too hot: the controller switches it off
    HOMELESS = "homing"  # a home switch is broken: this axis never finds its home
    REBOOT = "reboot"  # the power was off for a moment


class Controller(ABC):
    """An arm's controller as a state machine; time is an argument and never runs backwards [s]."""

    command_mark: ClassVar[bytes] = b"\r"  # occurs once in each command
    _axes: Sequence[Axis]

    @abstractmethod
    def receive(self, data: bytes, now_s: float) -> bytes:
        """Receive bytes, and return the immediate answer."""

    def poll(self, now_s: float) -> bytes:
        """Return reports that are due by now without a request."""
        return b""

    def motor(self, now_s: float) -> Array:
        """Joint angles as the encoders see them, (j,) [rad] or [m]."""
        return np.array([axis.at(now_s) for axis in self._axes])

    def outputs(self, now_s: float) -> frozenset[int]:
        """The digital outputs that are on."""
        return frozenset()

    @abstractmethod
    def inject(self, fault: ArmFault, axis: int, now_s: float) -> None:
        """Cause a fault; axes count from 1."""


class ServoChain(Controller):
    """Servos that share a line, each with an address and an absolute encoder; they answer requests only."""

    def __init__(self, cell: Cell) -> None:
        robot, arm = cell.robot, cell.arm
        count = len(robot.joints)
        self._ids = tuple(arm.ids or range(1, count + 1))
        self._reference = np.array(arm.reference_rad or [0.0] * count)
        self._direction = np.array(arm.direction or [1.0] * count)
        self._lower, self._upper = robot.lower, robot.upper
        self._axes = [Axis(float(q)) for q in np.clip(self._reference, robot.lower, robot.upper)]

    def _turned(self, i: int, angle: float) -> float:
        """Angle of a servo from its middle, at a joint angle [rad]."""
        return float(self._direction[i] * (angle - self._reference[i]))

    def _within_limits(self, i: int, turned: float) -> tuple[float, float]:
        """The allowed joint angle nearest to a servo's angle from its middle, and the difference [rad]."""
        wanted = float(self._reference[i] + self._direction[i] * turned)
        angle = float(np.clip(wanted, self._lower[i], self._upper[i]))
        return angle, abs(angle - wanted)
