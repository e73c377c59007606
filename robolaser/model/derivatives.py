"""Derivatives of the forward model's residuals: its effects and its sensors run on duals."""

from typing import Any, cast

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import Dual
from robolaser.model.forward_model import Model
from robolaser.parameters import Values


def jacobian(model: Model, x: Array) -> Array:
    """Derivatives of the residuals at candidates (c, d) by all parameters, (c, d, m, k), in their unit per unit."""
    values = {name: Dual.parameter(x[:, i], i) for i, name in enumerate(model.parameters.names)}
    residuals: Any = model.residuals_at(cast("Values", values))
    J = np.zeros((*x.shape, *residuals.shape[1:]))
    if isinstance(residuals, Dual):
        J[:, list(residuals.of)] = np.swapaxes(residuals.slopes, 0, 1)
    return J


def jacobian_matrix(model: Model, x: Array) -> Array:
    """The same at one candidate (d,), for all numbers of all rows, (m k, d)."""
    J = jacobian(model, x[None])[0]
    return np.asarray(J.reshape(len(J), -1).T)
