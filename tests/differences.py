"""Derivatives by differences, an independent check of computed ones."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array


def central_differences(function: Callable[[Array], Array], steps: Array) -> Array:
    """Derivatives at zero of a function of small shifts, (n, d) -> (n, ...), given the steps (d,): (..., d)."""
    ahead, behind = function(np.diag(steps)), function(-np.diag(steps))
    return np.asarray(np.moveaxis(ahead - behind, 0, -1) / (2 * steps))
