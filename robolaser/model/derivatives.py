"""Derivatives of the forward model's residuals: analytic where the sensor has them, else central differences.

This is the only place where residuals are differentiated numerically.
"""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.model.forward_model import Model

STEP = 1e-5
"""Of a central difference, in units of a parameter's range: truncation and rounding are both near 1e-10 there."""
BATCH = 4_000_000
"""Numbers that the residuals of a batch of shifted candidates may have: 32 MB."""


def differences(
    function: Callable[[Array], Array],
    x: Array,
    step: Array,
    columns: Ints,
    lower: Array,
    upper: Array,
    *,
    middle: Array | None = None,
) -> Array:
    """Derivatives of a function by some of its variables, central differences of second order.

    At a bound both points are on the inner side of it; where one of the two is not finite, the other and the middle
    make a one-sided difference; where neither is, the derivative is zero.

    Args:
        function: Candidates (n, d) -> (n, k).
        x: Candidates, (c, d).
        step: Of each variable, (d,), at most a quarter of the distance between its bounds.
        columns: Numbers of the variables, (q,).
        lower: Lower bounds, (d,).
        upper: Upper bounds, (d,).
        middle: The function at x, (c, k), where it is known.

    Returns:
        (c, q, k).
    """
    c, q = len(x), len(columns)
    middle = function(x) if middle is None else middle
    J = np.zeros((c, q, middle.shape[1]))
    at_once = max(1, BATCH // max(1, 2 * c * middle.shape[1]))
    for first in range(0, q, at_once):
        some = columns[first : first + at_once]
        h = step[some]
        above, below = upper[some] - x[:, some] >= h, x[:, some] - lower[some] >= h
        near = np.where(above, h, -h)
        far = np.where(above & below, -h, 2.0 * near)
        shifted = np.repeat(x[:, None, None], len(some), axis=1).repeat(2, axis=2)
        every = np.arange(len(some))
        shifted[:, every, 0, some] += near
        shifted[:, every, 1, some] += far
        moved = function(shifted.reshape(-1, x.shape[1])).reshape(c, len(some), 2, -1)
        near, far = ((shifted[:, every, side, some] - x[:, some])[..., None] for side in (0, 1))
        J[:, first : first + at_once] = _three_points(moved[:, :, 0], moved[:, :, 1], middle[:, None], near, far)
    return J


def _three_points(near: Array, far: Array, middle: Array, to_near: Array, to_far: Array) -> Array:
    """The derivative (c, q, k) of the parabola through a middle point and two at the given distances (c, q, 1)."""
    good_near, good_far = (np.isfinite(side.sum(axis=-1, keepdims=True)) for side in (near, far))
    with np.errstate(invalid="ignore", over="ignore"):
        if good_near.all() and good_far.all() and np.array_equal(to_near, -to_far):
            return np.asarray((near - far) / (2.0 * to_near))
        of_near, of_far = (near - middle) / to_near, (far - middle) / to_far
        both = (of_near * to_far - of_far * to_near) / (to_far - to_near)
    one = np.where(good_near, of_near, np.where(good_far, of_far, 0.0))
    return np.where(good_near & good_far, both, one)


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
    m, k = len(model.dataset.points), model.sensor.format.numbers
    J = np.empty((*x.shape, m, k))
    analytic = 0 if known is None else known.shape[-1]
    if known is not None:
        J[:, :analytic] = np.moveaxis(known, -1, 1)
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
