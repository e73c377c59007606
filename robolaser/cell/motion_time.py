"""How fast a motion is, and how long it takes."""

import numpy as np

from robolaser.arrays import Array

PEAK = 1.875
"""Highest speed over mean speed of the smoothest motions usual (a polynomial of fifth degree)."""
LEAST_S = 0.5


def seconds_for(way: Array, speed: float) -> float:
    """Time for a motion so that no joint ever exceeds a speed [s].

    Args:
        way: Differences of joint values, (j,) [rad or m].
        speed: [rad/s or m/s].
    """
    return max(LEAST_S, PEAK * float(np.abs(way).max(initial=0.0)) / speed)


def way_in(seconds: float, speed: float) -> float:
    """How far a joint goes at most in a motion so that it never exceeds a speed [rad or m]."""
    return seconds * speed / PEAK
