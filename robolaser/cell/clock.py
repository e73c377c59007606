"""The clock, and the durations of motions."""

import time
from typing import final

import numpy as np

from robolaser.arrays import Array

PEAK = 1.875  # highest speed over mean speed of the smoothest motions usual (a polynomial of fifth degree)
LEAST_S = 0.5


@final
class Clock:
    """Wall-clock time."""

    def now(self) -> float:
        """Seconds since an arbitrary instant; never runs backwards."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Wait [s]."""
        time.sleep(seconds)


def seconds_for(way: Array, speed: float) -> float:
    """Least duration [s] of a smooth motion, (j,) [rad or m], within a speed of each joint [rad/s or m/s]."""
    return max(LEAST_S, PEAK * float(np.abs(way).max(initial=0.0)) / speed)


def way_in(seconds: float, speed: float) -> float:
    """Longest smooth motion of a joint [rad or m] in a time [s] within a speed [rad/s or m/s]."""
    return seconds * speed / PEAK
