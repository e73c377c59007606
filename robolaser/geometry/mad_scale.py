"""How widely values scatter, told by their middle half: strays do not count."""

import numpy as np

from robolaser.arrays import Array

SIGMAS_PER_MEDIAN = 1.4826
"""Standard deviation of a Gaussian over the median of its distances from zero."""


def spread(values: Array) -> float:
    """Standard deviation of values about zero as their median tells it."""
    return SIGMAS_PER_MEDIAN * float(np.median(np.abs(values)))
