"""The scale of values by their median absolute deviation: outliers hardly change it."""

import numpy as np

from robolaser.arrays import Array

SIGMAS_PER_MEDIAN = 1.4826  # standard deviation of a Gaussian over the median of its distances from zero


def mad_scale(values: Array) -> float:
    """Standard deviation of values about zero, estimated from the median of their absolute values."""
    return SIGMAS_PER_MEDIAN * float(np.median(np.abs(values)))
