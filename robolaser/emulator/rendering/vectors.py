"""Products of many short vectors at once."""

import numpy as np

from robolaser.arrays import Array


def dot(one: Array, other: Array) -> Array:
    """Inner products, (..., 3) and (..., 3) -> (...,)."""
    return np.asarray(np.einsum("...i,...i->...", one, other))


def unit(vector: Array) -> Array:
    """The same directions with length 1, (..., 3) -> (..., 3)."""
    scaled: Array = vector / np.sqrt(dot(vector, vector))[..., None]
    return scaled
