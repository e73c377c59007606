"""Quantiles of numbers that may be infinite or absent."""

import numpy as np

from robolaser.arrays import Array


def quantiles(values: Array, levels: Array) -> Array:
    """Values at or below which lie so many of them, (..., n) and levels (q,) -> (..., q): always one that was seen.

    So infinite ones (runs that found nothing) do no harm; NaN is absent. Hyndman & Fan 1996, definition 1.
    """
    there = (~np.isnan(values)).sum(axis=-1, keepdims=True)
    at = np.clip(np.ceil(np.round(levels * there, 9)).astype(int) - 1, 0, np.maximum(there - 1, 0))
    picked: Array = np.take_along_axis(np.sort(values, axis=-1), at, axis=-1)  # NaN is sorted last
    return picked
