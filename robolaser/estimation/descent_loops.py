"""From many starts downhill at once: Levenberg-Marquardt steps of a bare stripe scanner within its bounds.

Each start goes its own way in one compiled loop. Derivatives are differences through the chain; variables on a bound
that J would push beyond it stand still; steps are bent where the valley bends (geodesic acceleration, Transtrum and
Sethna 2012); the damping follows Nielsen 1999. It finds the valley and its floor; the last digits are the polish's.
"""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled.decorators import compiled
from robolaser.model.sensors.stripe_loops import Scanner, errors_of_one

STEP = 1e-5
"""Of a central difference, in units of a variable's width."""
PROBE = 0.1
"""Share of a step at which its perturb is measured."""
BENT = 0.75
"""Most that the perturb may add to a step, as a share of its length."""
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-4, 1e-15, 1e12
PIVOT = 1e-14
"""Share of its diagonal entry below which a pivot is rounding: the step is damped more."""


@compiled
def descend(
    first: int,
    last: int,
    starts: Array,
    lower: Array,
    upper: Array,
    scanner: Scanner,
    steps: int,
    tol: float,
    ends: Array,
    costs: Array,
    evaluations: Ints,
) -> None:
    """Go down from each start.

    Args:
        first: Number of the first start.
        last: The one after the last.
        starts: Within the bounds, (k, d).
        lower: Lower bounds, (d,); variables with equal bounds are held.
        upper: Upper bounds, (d,).
        scanner: As for `errors_of_one`.
        steps: At most, from each start.
        tol: A start has arrived when a step promises to lower J by no more than this share of it.
        ends: Takes where each start arrived, (k, d).
        costs: Takes J there, (k,) [m²]; not finite for starts at a pole.
        evaluations: Takes how many times each evaluated residuals, (k,).
    """
    bracket, zyz, along_u, image, target, runs, flange, known = scanner
    scanner = (bracket, zyz, along_u, image, target, runs, flange, known.copy())
    d, rows = starts.shape[1], 3 * image.shape[2]
    width = upper - lower
    J, e, ahead, second = np.zeros((d, rows)), np.empty(rows), np.empty(rows), np.empty(rows)
    A, g, diagonal, free = np.empty((d, d)), np.empty(d), np.empty(d), np.empty(d, np.bool_)
    L, straight, perturb, right = np.empty((d, d)), np.empty(d), np.empty(d), np.empty(d)
    x, trial = np.empty((1, d)), np.empty((1, d))
    for start in range(first, last):
        x[0], diagonal[:] = starts[start], 0.0
        cost = errors_of_one(x, 0, scanner, e)
        evaluated, damping, growth, fresh = 1, FIRST_DAMPING, 2.0, True
        for _ in range(steps):
            if not np.isfinite(cost) or damping > MOST_DAMPING:
                break
            if fresh:
                evaluated += _differentiate(x, width, scanner, ahead, second, J)
                _normal(J, e, A, g)
                _loosen(x[0], g, A, lower, upper, diagonal, free)
                fresh = False
            if not _factored(A, diagonal, free, damping, L):
                damping *= 10.0
                continue
            _solved(L, free, g, straight)
            promised = damping * _size(diagonal, straight) - np.dot(g, straight)
            if promised <= tol * cost:
                break
            trial[0] = x[0] + PROBE * straight * width
            bends = np.isfinite(errors_of_one(trial, 0, scanner, ahead))
            _bend(J, e, ahead, straight, second, right)
            _solved(L, free, right, perturb)
            if bends and _size(diagonal, perturb) <= (2.0 * BENT) ** 2 * _size(diagonal, straight):
                straight += 0.5 * perturb
            trial[0] = np.minimum(np.maximum(x[0] + straight * width, lower), upper)
            there = errors_of_one(trial, 0, scanner, ahead)
            evaluated += 2
            if there < cost:
                kept = min((cost - there) / promised, 1.0)
                damping = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * kept - 1.0) ** 3), LEAST_DAMPING)
                growth, fresh = 2.0, True
                x[0], e[:], cost = trial[0], ahead, there
            else:
                damping *= growth
                growth *= 2.0
        ends[start], costs[start], evaluations[start] = x[0], cost, evaluated


@compiled
def _differentiate(x: Array, width: Array, scanner: Scanner, ahead: Array, behind: Array, J: Array) -> int:
    """Residuals by each variable in units of its width, into the rows of J; how many times they were evaluated."""
    moved, evaluated = x.copy(), 0
    for j in range(len(width)):
        if width[j] > 0.0:
            moved[0, j] = x[0, j] + STEP * width[j]
            up = errors_of_one(moved, 0, scanner, ahead)
            moved[0, j] = x[0, j] - STEP * width[j]
            down = errors_of_one(moved, 0, scanner, behind)
            moved[0, j] = x[0, j]
            evaluated += 2
            good = np.isfinite(up) and np.isfinite(down)
            for r in range(len(ahead)):
                J[j, r] = (ahead[r] - behind[r]) / (2.0 * STEP) if good else 0.0
    return evaluated


@compiled
def _normal(J: Array, e: Array, A: Array, g: Array) -> None:
    """J Jᵀ and J e for derivatives in rows."""
    for i in range(len(J)):
        for j in range(i + 1):
            total = 0.0
            for r in range(len(e)):
                total += J[i, r] * J[j, r]
            A[i, j] = total
            A[j, i] = total
        total = 0.0
        for r in range(len(e)):
            total += J[i, r] * e[r]
        g[i] = total


@compiled
def _loosen(x: Array, g: Array, A: Array, lower: Array, upper: Array, diagonal: Array, free: Bools) -> None:
    """Which variables may move, and the largest derivatives so far, by which steps are damped."""
    for j in range(len(x)):
        diagonal[j] = max(diagonal[j], A[j, j])
        outward = (x[j] <= lower[j] and g[j] > 0.0) or (x[j] >= upper[j] and g[j] < 0.0)
        free[j] = upper[j] > lower[j] and A[j, j] > 0.0 and not outward


@compiled
def _bend(J: Array, e: Array, ahead: Array, step: Array, second: Array, right: Array) -> None:
    """How the residuals perturb along a step, `second`, and its product with their derivatives, `right`."""
    for r in range(len(e)):
        straight = 0.0
        for j in range(len(J)):
            straight += J[j, r] * step[j]
        second[r] = 2.0 / PROBE * ((ahead[r] - e[r]) / PROBE - straight)
    for j in range(len(J)):
        total = 0.0
        for r in range(len(e)):
            total += J[j, r] * second[r]
        right[j] = total


@compiled
def _size(diagonal: Array, step: Array) -> float:
    """Squared length of a step as the damping sees it."""
    total = 0.0
    for j in range(len(step)):
        total += diagonal[j] * step[j] * step[j]
    return total


@compiled
def _factored(A: Array, diagonal: Array, free: Bools, damping: float, L: Array) -> bool:
    """Cholesky factor of A with a damped diagonal, over the free variables; whether there is one."""
    for i in range(len(A)):
        for j in range(i + 1):
            if not (free[i] and free[j]):
                continue
            total = A[i, j] + (damping * diagonal[i] if i == j else 0.0)
            for k in range(j):
                if free[k]:
                    total -= L[i, k] * L[j, k]
            if i == j and not total > PIVOT * A[i, i]:
                return False
            L[i, j] = np.sqrt(total) if i == j else total / L[j, j]
    return True


@compiled
def _solved(L: Array, free: Bools, right: Array, step: Array) -> None:
    """-(L Lᵀ)⁻¹ right over the free variables; the others do not move."""
    d = len(L)
    for i in range(d):
        step[i] = 0.0
        if free[i]:
            total = -right[i]
            for k in range(i):
                if free[k]:
                    total -= L[i, k] * step[k]
            step[i] = total / L[i, i]
    for i in range(d - 1, -1, -1):
        if free[i]:
            total = step[i]
            for k in range(i + 1, d):
                if free[k]:
                    total -= L[k, i] * step[k]
            step[i] = total / L[i, i]
