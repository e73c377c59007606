"""One-sided differences, for Newton's method in the worlds of trials."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array


def forward_differences(function: Callable[[Array], Array], steps: Array, at_zero: Array) -> Array:
    """Derivatives at zero of a function of small shifts, of first order in their steps.

    Args:
        function: Shifts (d, d) -> (d, ...).
        steps: Of each variable, (d,).
        at_zero: The function at zero, (...).

    Returns:
        (..., d), in the function's unit per unit of each variable.
    """
    return np.asarray(np.moveaxis(function(np.diag(steps)) - at_zero, 0, -1) / steps)
