"""Tracking errors of hobby servos: dead time, lag, dead zone and droop."""

from collections import deque
from collections.abc import Callable, Mapping
from typing import Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot

STEP_S: Final = 0.005
SHORTEST_LAG_S: Final = 1e-4
SERVO_FAULTS: Final = ("dead_time", "lag", "dead_zone", "droop")
"""Faults of a servo in world.toml: [s], [s], half width [rad], [rad/Nm]."""


@final
class ServoLoop:
    """Joints that follow their commands with dead time, lag, dead zone and droop.

    Faults are sizes by name and joint; droop follows the gravity torques.
    """

    def __init__(self, arm: Robot, faults: Mapping[tuple[str, str], float]) -> None:
        self._arm = arm
        delay, lag, self._dead, self._droop = (
            np.array([faults.get((name, joint), 0.0) for joint in arm.joints]) for name in SERVO_FAULTS
        )
        self._share = -np.expm1(-STEP_S / np.maximum(lag, SHORTEST_LAG_S))
        self._late = np.rint(delay / STEP_S).astype(np.int64)
        self._commands: deque[Array] = deque(maxlen=int(self._late.max()) + 1)
        self._q: Array | None = None
        self._now_s = 0.0

    def follow(self, command: Callable[[float], Array], now_s: float) -> Array:
        """Joint angles, (j,) [rad], for commands by time; time never runs backwards [s]."""
        if self._q is None:
            self._q, self._now_s = command(now_s), now_s
            self._commands.extend([self._q] * (self._commands.maxlen or 1))
        if self._now_s + STEP_S > now_s:
            return self._q
        sinks = self._droop * self._arm.gravity_torques(self._q)
        while self._now_s + STEP_S <= now_s:
            self._now_s += STEP_S
            self._commands.appendleft(command(self._now_s))
            delayed = np.array([self._commands[k][i] for i, k in enumerate(self._late.tolist())])
            off = delayed - sinks - self._q
            self._q = self._q + self._share * (off - np.clip(off, -self._dead, self._dead))
        return self._q
