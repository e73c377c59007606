"""Derivatives of all numbers of a model's rows, as one matrix."""

from robolaser.arrays import Array
from robolaser.model import derivatives
from robolaser.model.forward_model import Model


def jacobian(model: Model, x: Array) -> Array:
    """Derivatives of the residuals at x (d,) by every parameter, (K, d)."""
    J: Array = derivatives.jacobian(model, x[None])[0]
    return J.reshape(len(J), -1).T
