"""Newton's method within bounds, for many small problems at once."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools, Ints

STEPS = 40  # ten are usual
CALM = 1e-14  # of a problem's size: sums of squares of that size differ by this from one rounding to the next
DONE = 1e-20  # of the same: a step that promises less changes nothing any more
WORTH = 1e-3  # of what a step promised, it must hold at least
PIVOTS = 6  # more than there are variables
FIRST = 0.1  # damping once a step has failed, in units of the curvature's diagonal
FIRM, LOOSE = 10.0, 0.1  # the damping after a step that failed, and after one that did what it promised
HOPELESS = 1e9  # damping at which steps no longer move anything

Objective = Callable[[Array, Ints], tuple[Array, Array, Array]]
"""Values (k,), gradients (k, n) and Hessians (k, n, n) of the problems with these numbers (k,) at x (k, n)."""


def minimise(objective: Objective, start: Array, lower: Array, upper: Array, size: Array) -> tuple[Array, Array]:
    """Go downhill within bounds from a start for each problem.

    Each step minimises the local quadratic model in the box, its curvature damped where it promised too much.

    Args:
        objective: The problems.
        start: (c, n); moved into the bounds.
        lower: (c, n).
        upper: (c, n).
        size: (c,), what the objective's terms amount to before they cancel: sets what counts as rounding.

    Returns:
        Where each problem ends (c, n), and its value there (c,).
    """
    x = np.clip(start, lower, upper)
    J, g, H = objective(x, np.arange(len(x)))
    damping = np.zeros(len(x))
    going = np.arange(len(x))
    for _ in range(STEPS):
        if not len(going):
            break
        at, low, high = x[going], lower[going], upper[going]
        curved = H[going].copy()
        diagonal = np.einsum("kii->ki", curved)
        diagonal += damping[going, None] * np.abs(diagonal)
        step, settled = _boxed(curved, g[going], low - at, high - at)
        promised = -np.einsum("ki,ki->k", step, g[going] + 0.5 * np.einsum("kij,kj->ki", H[going], step))
        tried = np.clip(at + step, low, high)
        there = objective(tried, going)
        gained = J[going] - there[0]
        whole = size[going] + np.abs(J[going])
        good = settled & (promised >= 0) & (gained >= WORTH * promised - CALM * whole)
        took = going[good]
        x[took], J[took], g[took], H[took] = tried[good], there[0][good], there[1][good], there[2][good]
        damping[going] = np.where(good, LOOSE * damping[going], np.maximum(FIRM * damping[going], FIRST))
        damping[damping < FIRST * LOOSE] = 0.0
        done = (settled & (np.abs(promised) <= DONE * whole)) | (damping[going] > HOPELESS)
        going = going[~done]
    return x, J


def _boxed(H: Array, g: Array, lower: Array, upper: Array) -> tuple[Array, Bools]:
    """Steps that minimise g·s + s·H·s/2 with s in a box, (k, n), and whether each is such a minimum, (k,).

    Block principal pivoting (Portugal, Júdice, Vicente 1994): variables go to a bound and come back, all that are on
    the wrong side at once. Where H is not positive definite it may not settle.
    """
    side = np.where((lower >= 0) & (g > 0), -1, np.where((upper <= 0) & (g < 0), 1, 0))
    side = np.where(lower >= upper, -1, side)
    step, settled = np.zeros_like(g), np.ones(len(g), dtype=bool)
    left = np.arange(len(g))
    for _ in range(PIVOTS + g.shape[1]):
        now, low, high = side[left], lower[left], upper[left]
        step[left], pull = _solved(H[left], g[left], now, np.where(now < 0, low, np.where(now > 0, high, 0.0)))
        to = np.where(step[left] < low, -1, np.where(step[left] > high, 1, 0))
        to = np.where((now != 0) & (now * pull <= 0), now, np.where(now != 0, 0, to))
        to = np.where(low >= high, -1, to)
        wrong = (to != now).any(axis=1)
        side[left] = to
        left = left[wrong]
        if not len(left):
            break
    settled[left] = False
    return np.clip(step, lower, upper), settled


def _solved(H: Array, g: Array, side: Ints, held: Array) -> tuple[Array, Array]:
    """The free variables' best against the steps of those that are held, and the gradient there, (k, n) both."""
    fixed = side != 0
    right = np.where(fixed, held, -(g + np.einsum("kij,kj->ki", H, held)))
    A = np.where(fixed[:, :, None] | fixed[:, None, :], 0.0, H)
    np.einsum("kii->ki", A)[fixed] = 1.0
    try:
        step: Array = np.linalg.solve(A, right[..., None])[..., 0]
    except np.linalg.LinAlgError:
        step = (np.linalg.pinv(A, hermitian=True) @ right[..., None])[..., 0]
    step = np.where(fixed, held, step)
    return step, g + np.einsum("kij,kj->ki", H, step)
