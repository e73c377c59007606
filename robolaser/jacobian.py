"""How the residuals move with the parameters: derivatives exact enough to tell a null direction from a weak one."""

import numpy as np

from robolaser.arrays import Array
from robolaser.scanner import Model

STEP = 1e-4
"""Of a parameter's width: with the fourth-order rule below, truncation and rounding are both near 1e-11."""

_AT = np.array([-2.0, -1.0, 1.0, 2.0])
_WEIGHT = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0


def jacobian(model: Model, x: Array) -> Array:
    """Derivative of the residuals with respect to every parameter, at x (d,).

    Args:
        model: Gives residuals in the order of its rows, three to a row.
        x: One candidate in the order of `model.parameters`, (d,).

    Returns:
        (3m, d), a column in metres per unit of its parameter. Central differences of fourth order.
    """
    step = STEP * model.parameters.width
    d = len(x)
    moved = x + (_AT[:, None, None] * np.diag(step)).reshape(-1, d)
    e = model.residuals(moved).reshape(4, d, -1)
    slopes: Array = np.einsum("s,sdm->md", _WEIGHT, e) / step
    return slopes
