"""Numerical differentiation: every finite difference of the package is taken here.

The stencil is central and of second order, f′(x) ≈ (f(x + h) - f(x - h)) / 2h. Its truncation error is h² f‴/6 and its
rounding error about ε f/h, with ε = 2e-16. So a step h, in the unit of its variable, should be small beside the
distance over which the function bends and large beside rounding: about ε^(1/3), 1e-5, of that distance. Where only one
side can be evaluated, or where half the work matters more than accuracy, the difference is one-sided and of first
order; its truncation error is h f″/2.
"""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Ints

BATCH = 4_000_000  # numbers that the values of a function at a batch of shifted candidates may have: 32 MB


def central_differences(function: Callable[[Array], Array], steps: Array) -> Array:
    """Derivatives at zero of a function of small shifts.

    Args:
        function: Shifts (n, d) -> (n, ...).
        steps: Of each variable, (d,).

    Returns:
        (..., d), in the function's unit per unit of each variable.
    """
    ahead = np.diag(steps)
    values = function(np.concatenate([ahead, -ahead]))
    return np.asarray(np.moveaxis(values[: len(steps)] - values[len(steps) :], 0, -1) / (2 * steps))


def central_quotients(ends: Array, steps: Array) -> Array:
    """The same from a function's values at both ends of each step.

    Args:
        ends: Ahead and behind, (c, q, 2, ...).
        steps: (q,).

    Returns:
        (c, q, ...).
    """
    ahead, behind = ends[:, :, 0], ends[:, :, 1]
    return np.asarray((ahead - behind) / (2.0 * steps).reshape(-1, *(1,) * (ahead.ndim - 2)))


def forward_differences(function: Callable[[Array], Array], steps: Array, at_zero: Array) -> Array:
    """The same by one-sided differences, given the function at zero (...): half the evaluations."""
    return np.asarray(np.moveaxis(function(np.diag(steps)) - at_zero, 0, -1) / steps)


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
