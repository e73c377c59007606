"""The last digits: damped Gauss-Newton steps within bounds, from a good start to the optimum.

Derivatives are central differences, all columns in one batch of candidates; the trial steps of an iteration, one for
each of a ladder of dampings, are others. So a fast kernel that takes many candidates at once is well used. Where few
poses leave a long bent valley, straight steps leave it soon: each step is bent as the residuals are along it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.estimation.bounded_step import Linear
from robolaser.estimation.differences import EPS, Around
from robolaser.estimation.robust_loss import Loss
from robolaser.estimation.rows import Rows

NOISE = 10.0 * EPS ** (2 / 3)
"""Singular values of a Jacobian below this share of the largest are rounding errors of the differences."""
LADDER = np.array([0.0, 1e-3, 1e-2, 1e-1, 1e0, 1e1, 1e2, 1e3])
"""Dampings tried at once, relative to the last that was good; 0 is the undamped step."""
BENDS = 0.75
"""Length of the acceleration, relative to the step, up to which it is believed."""
KEPT_PROMISE = 0.9
"""Share of a step's promise that, once kept, spares the trial of more damped ones, where they are not tried at once."""
_START, _LEAST, _MOST = 1e-4, 1e-13, 1e13
"""First, smallest and largest damping, relative to the square of the largest singular value."""
SQUARE = Loss()


@final
@dataclass(frozen=True, eq=False)
class Polished:
    """Where the polish ended.

    Args:
        x: The optimum, (d,).
        cost: Sum of squared residuals at x, or of their losses; infinite if they are not finite at the start, which is
            then x.
        iterations: Steps taken.
        evaluations: Candidates evaluated, those for derivatives included.
        converged: No step promises to lower the cost by more than its rounding error or the tolerance.
        on_bound: Variables that ended on a bound, (d,); those without room are not counted.
    """

    x: Array
    cost: float
    iterations: int
    evaluations: int
    converged: bool
    on_bound: Bools


def gauss_newton(
    residuals: Callable[[Array], Array] | Iterable[Callable[[Array], Array]],
    x0: Array,
    lower: Array,
    upper: Array,
    *,
    scale: Array | None = None,
    loss: Loss = SQUARE,
    tol: float = 1e-12,
    max_iterations: int = 100,
) -> Polished:
    """Minimise the sum of squared residuals within bounds. Levenberg 1944, Marquardt 1963, Transtrum and Sethna 2012.

    A candidate with a residual that is not finite is infinitely bad: steps shrink until they avoid it. Directions
    that the residuals do not depend on (gauge freedom, k < d) are not moved along: steps are the shortest, measured
    in units of `scale`.

    Args:
        residuals: Takes candidates within the bounds, (c, d) -> (c, k). Several: blocks of residuals, each with a k of
            its own; no more than one block's derivatives are kept at a time.
        x0: Start, (d,); moved to the nearest point within the bounds.
        lower: Lower bounds, (d,); may be -inf.
        upper: Upper bounds, (d,); may be inf.
        scale: A typical change of each variable, (d,); by default the distance of its bounds or, without bounds,
            |x0|, at least 1.
        loss: What residuals cost; their squares by default. For others they come in rows of three.
        tol: Stop when no step promises to lower the cost by more than this share of it.
        max_iterations: Stop after so many steps.

    Raises:
        ResidualsShape: `residuals` does not return one row for each candidate.
    """
    x = np.clip(np.asarray(x0, np.float64), lower, upper)
    if scale is None:
        width = np.where(upper > lower, upper - lower, 1.0)
        scale = np.where(np.isfinite(width), width, np.maximum(np.abs(x), 1.0))
    rows = Rows((residuals,) if callable(residuals) else tuple(residuals), loss, x)
    cost, iterations = rows.cost, 0
    damping, converged = _START, False
    while np.isfinite(cost) and iterations < max_iterations:
        at = Around(x, lower, upper, scale)
        R, rounding = rows.around(at)
        model, r = Linear(R[:, :-1], NOISE), R[:, -1]
        x_new, cost_new, promised, tried = x, cost, 0.0, damping
        while cost_new >= cost and tried <= _MOST:
            steps, gains = model.steps(r, *at.room, tried * LADDER)
            promised = max(promised, float(gains.max()))
            if promised <= max(tol * cost, rounding):
                break
            for some in rows.batches(len(LADDER)):
                pulls = rows.bends(at, steps[some])
                trials = at.moved(bent(model, r, steps[some], pulls, at.room, tried * LADDER[some]))
                costs = rows.costs(trials)
                best = int(np.argmin(costs))
                if costs[best] < cost_new:
                    x_new, cost_new = trials[best], float(costs[best])
                    damping = float(np.clip(tried * (LADDER[some][best] or LADDER[1]), _LEAST, _MOST))
                if cost - cost_new >= KEPT_PROMISE * gains[some].max():
                    break
            tried *= LADDER[-1] / LADDER[1] * 10.0
        at_rest = promised <= max(tol * cost, rounding)
        converged = at_rest or (cost - cost_new <= tol * cost and promised <= np.sqrt(tol) * cost)
        if cost_new >= cost:
            break
        x, cost, iterations = x_new, cost_new, iterations + 1
        if converged:
            break
    has_room = upper > lower
    on_bound = has_room & ((x <= lower) | (x >= upper))
    return Polished(x, cost, iterations, rows.evaluations, converged, on_bound)


def bent(model: Linear, r: Array, steps: Array, pulls: Array, room: tuple[Array, Array], dampings: Array) -> Array:
    """Scaled steps (c, d) with half their acceleration; straight where that is too large to be believed.

    Transtrum, Sethna 2012, Improvements to the Levenberg-Marquardt algorithm. The acceleration that the second
    derivatives E'' along a step call for is the step itself for the residuals E'': half of them beside E give both.

    Args:
        model: Of the residuals.
        r: The residuals as it has them, (k,).
        steps: What it says, (c, d).
        pulls: JᵀE'' along each step, (c, d).
        room: How far steps may go down and up, (d,) each.
        dampings: Of each step, (c,).
    """
    turned, _ = model.steps(r + model.pulling(pulls) / 2.0, *room, dampings)
    believed = 2.0 * np.linalg.norm(turned - steps, axis=1) <= BENDS * np.linalg.norm(steps, axis=1)
    return np.where(believed[:, None], turned, steps)
