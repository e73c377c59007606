"""Derivatives of the forward model's residuals: analytic where the sensor has them, else central differences."""

import numpy as np

from robolaser.arrays import Array
from robolaser.finite_differences import differences
from robolaser.model.forward_model import Model

STEP = 1e-5
"""Of a central difference, in units of a parameter's range: truncation and rounding are both near 1e-10 there."""


def jacobian(model: Model, x: Array) -> Array:
    """Derivatives of the residuals by all parameters.

    By the sensor's own where it knows them, by the others, such as those of effects, numerically.

    Args:
        model: With its effects.
        x: Candidates in the order of `model.parameters`, (c, d).

    Returns:
        (c, d, m, k), in the residuals' unit per unit of each parameter.
    """
    values = model.parameters.values(x)
    perturb = model.perturb(values)
    known = model.sensor.jacobian(values, model.flange(values, perturb), perturb)
    names = model.sensor.free + model.sensor.derived
    if known is not None and names == model.parameters.names:
        return np.require(np.moveaxis(known, -1, 1), requirements=["C", "W"])
    m, k = len(model.dataset.points), model.sensor.format.numbers
    J = np.zeros((*x.shape, m, k))  # rows may know nothing of places that other rows see
    analytic = 0 if known is None else x.shape[1] - len(model.effect_parameters)
    if known is not None:
        J[:, model.parameters.columns(names)] = np.moveaxis(known, -1, 1)
    if analytic < x.shape[1]:
        numeric, everywhere = np.arange(analytic, x.shape[1]), np.full(x.shape[1], np.inf)

        def flat(candidates: Array) -> Array:
            return model.residuals(candidates).reshape(len(candidates), -1)

        slopes = differences(flat, x, STEP * model.parameters.width, numeric, -everywhere, everywhere)
        J[:, analytic:] = slopes.reshape(len(x), -1, m, k)
    return J


def jacobian_matrix(model: Model, x: Array) -> Array:
    """The same at one candidate (d,), for all numbers of all rows, (m k, d)."""
    J = jacobian(model, x[None])[0]
    return np.asarray(J.reshape(len(J), -1).T)
