"""The last digits: damped Gauss-Newton steps within bounds, from a good start to the optimum.

Derivatives are central differences, all columns in one batch of candidates; the trial steps of an iteration, one for
each of a ladder of dampings, are a second batch. So a fast kernel that takes many candidates at once is well used.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.algorithms.bounded_step import bounded_steps
from robolaser.arrays import Array, Bools
from robolaser.errors import ResidualsShape

_EPS = float(np.finfo(np.float64).eps)
_DIFFERENCE = _EPS ** (1 / 3)
"""Step of a central difference, in units of the scale: where its two errors, curvature and rounding, are equal."""
_NOISE = 10.0 * _EPS ** (2 / 3)
"""Singular values of a Jacobian below this share of the largest are rounding errors of the differences."""
_LADDER = np.array([0.0, 1e-3, 1e-2, 1e-1, 1e0, 1e1, 1e2, 1e3])
"""Dampings tried at once, relative to the last that was good; 0 is the undamped step."""
_START, _LEAST, _MOST = 1e-4, 1e-13, 1e13
"""First, smallest and largest damping, relative to the square of the largest singular value."""


@final
@dataclass(frozen=True, eq=False)
class Polished:
    """Where the polish ended.

    Args:
        x: The optimum, (d,).
        cost: Sum of squared residuals at x; infinite if they are not finite at the start, which is then x.
        jacobian: Derivatives of the residuals at x, (k, d); 0 for variables without room, lower = upper.
        iterations: Steps taken.
        evaluations: Candidates evaluated, those for derivatives included.
        converged: No step promises to lower the cost by more than its rounding error or the tolerance.
        on_bound: Variables that ended on a bound, (d,); those without room are not counted.
    """

    x: Array
    cost: float
    jacobian: Array
    iterations: int
    evaluations: int
    converged: bool
    on_bound: Bools


def gauss_newton(
    residuals: Callable[[Array], Array],
    x0: Array,
    lower: Array,
    upper: Array,
    *,
    scale: Array | None = None,
    tol: float = 1e-12,
    max_iterations: int = 100,
) -> Polished:
    """Minimise the sum of squared residuals within bounds. Levenberg 1944, Marquardt 1963.

    A candidate with a residual that is not finite is infinitely bad: steps shrink until they avoid it. Directions
    that the residuals do not depend on (gauge freedom, k < d) are not moved along: steps are the shortest, measured
    in units of `scale`.

    Args:
        residuals: Takes candidates within the bounds, (c, d) -> (c, k).
        x0: Start, (d,); moved to the nearest point within the bounds.
        lower: Lower bounds, (d,); may be -inf.
        upper: Upper bounds, (d,); may be inf.
        scale: A typical change of each variable, (d,); by default the distance of its bounds or, without bounds,
            |x0|, at least 1.
        tol: Stop when no step promises to lower the cost by more than this share of it.
        max_iterations: Stop after so many steps.

    Raises:
        ResidualsShape: `residuals` does not return one row for each candidate.
    """
    x = np.clip(np.asarray(x0, np.float64), lower, upper)
    has_room = upper > lower
    if scale is None:
        width = np.where(has_room, upper - lower, 1.0)
        scale = np.where(np.isfinite(width), width, np.maximum(np.abs(x), 1.0))

    rows, costs = _evaluate(residuals, x[None])
    r, cost, evaluations = rows[0], float(costs[0]), 1
    on_bound = has_room & ((x <= lower) | (x >= upper))
    if not np.isfinite(cost):
        unknown = np.full((len(r), len(x)), np.nan)
        return Polished(x, cost, unknown, 0, evaluations, converged=False, on_bound=on_bound)

    damping, converged = _START, False
    for iterations in range(max_iterations + 1):
        J = _differentiate(residuals, x, r, lower, upper, scale)
        evaluations += 2 * int(has_room.sum())
        if converged or iterations == max_iterations:
            break

        x_new, r_new, cost_new = x, r, cost
        promised, tried = 0.0, damping
        while cost_new >= cost and tried <= _MOST:
            down, up = (lower - x) / scale, (upper - x) / scale
            steps, gains = bounded_steps(J * scale, r, down, up, tried * _LADDER, _NOISE)
            promised = max(promised, float(gains.max()))
            if promised <= max(tol * cost, _rounding(J, x)):
                converged = True
                break
            trials = _move(x, steps, lower, upper, scale)
            rows, costs = _evaluate(residuals, trials)
            evaluations += len(trials)
            best = int(np.argmin(costs))
            if costs[best] < cost:
                x_new, r_new, cost_new = trials[best], rows[best], float(costs[best])
                damping = float(np.clip(tried * (_LADDER[best] or _LADDER[1]), _LEAST, _MOST))
            tried *= _LADDER[-1] / _LADDER[1] * 10.0
        if cost - cost_new <= tol * cost:
            converged = converged or promised <= np.sqrt(tol) * cost
            if cost_new >= cost:
                break
        x, r, cost = x_new, r_new, cost_new

    on_bound = has_room & ((x <= lower) | (x >= upper))
    return Polished(x, cost, J, iterations, evaluations, converged, on_bound)


def _evaluate(residuals: Callable[[Array], Array], candidates: Array) -> tuple[Array, Array]:
    rows = np.asarray(residuals(candidates), np.float64)
    if rows.ndim != 2 or len(rows) != len(candidates):
        raise ResidualsShape(len(candidates), rows.shape)
    with np.errstate(over="ignore", invalid="ignore"):
        costs = np.einsum("ck,ck->c", rows, rows)
    return rows, np.where(np.isfinite(costs), costs, np.inf)


def _differentiate(
    residuals: Callable[[Array], Array], x: Array, r: Array, lower: Array, upper: Array, scale: Array
) -> Array:
    """Derivatives (k, d) by three points: two and x, one on each side of it or, at a bound, both on the inner."""
    moving = np.flatnonzero(upper > lower)
    J = np.zeros((len(r), len(x)))
    if len(moving) == 0:
        return J
    step = np.minimum(np.maximum(_DIFFERENCE * scale, _DIFFERENCE**2 * np.abs(x)), (upper - lower) / 4.0)[moving]
    up, down = (upper - x)[moving] >= step, (x - lower)[moving] >= step
    near = np.where(up, step, -step)
    far = np.where(up & down, -step, 2.0 * near)

    points = np.tile(x, (2, len(moving), 1))
    columns = np.arange(len(moving))
    points[0, columns, moving] += near
    points[1, columns, moving] += far
    points = np.clip(points, lower, upper)
    near, far = (points[:, columns, moving] - x[moving])[..., None]

    rows, costs = _evaluate(residuals, points.reshape(-1, len(x)))
    good = np.isfinite(costs).reshape(2, -1)[..., None]
    rows = np.where(good, rows.reshape(2, len(moving), -1), r)
    to_near, to_far = (rows[0] - r) / near, (rows[1] - r) / far
    slopes = np.where(good[1], (far * to_near - near * to_far) / (far - near), to_near)
    J[:, moving] = np.where(good[0], slopes, to_far).T
    return J


def _move(x: Array, steps: Array, lower: Array, upper: Array, scale: Array) -> Array:
    """Trial points (c, d); a step up to a bound ends exactly on it."""
    inside = np.clip(x + scale * steps, lower, upper)
    inside = np.where(steps >= (upper - x) / scale, upper, inside)
    return np.where(steps <= (lower - x) / scale, lower, inside)


def _rounding(J: Array, x: Array) -> float:
    """Smallest cost that residuals can have by chance, when each variable is known to its last digit."""
    return float(_EPS**2 * np.sum((np.abs(J) @ np.abs(x)) ** 2))
