"""Where on a target a departure may start from: its middle and places around it."""

import numpy as np

from robolaser.arrays import Array


def centres(half: float) -> Array:
    """The middle of a plane of this half extent and eight places around it, counted from the middle, (9, 2) [m]."""
    return half * np.array([[x, y] for x in (0.0, -0.7, 0.7) for y in (0.0, -0.7, 0.7)])
