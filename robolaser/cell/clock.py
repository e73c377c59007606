"""The time that machines take: the clock, and how long motions last."""

import time
from typing import final

import numpy as np

from robolaser.arrays import Array

PEAK = 1.875  # highest speed over mean speed of the smoothest motions usual (a polynomial of fifth degree)
LEAST_S = 0.5


@final
class Clock:
    """The time on the wall."""

    def now(self) -> float:
        """Seconds since some moment; never runs backwards."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time go by."""
        time.sleep(seconds)


def seconds_for(way: Array, speed: float) -> float:
    """Time for a way, (j,) [rad or m], in which no joint ever exceeds a speed [rad/s or m/s], in s."""
    return max(LEAST_S, PEAK * float(np.abs(way).max(initial=0.0)) / speed)


def way_in(seconds: float, speed: float) -> float:
    """How far a joint goes at most in a motion so that it never exceeds a speed [rad or m]."""
    return seconds * speed / PEAK
