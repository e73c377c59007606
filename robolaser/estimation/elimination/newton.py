"""Newton's method within bounds, for many small problems at once."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.estimation.elimination.patience import CALM, DONE, FIRM, FIRST, HOPELESS, LOOSE, PIVOTS, STEPS, WORTH

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
        tried = np.clip(at + step, low, high)[settled]
        step, ready = step[settled], going[settled]
        promised = -np.einsum("ki,ki->k", step, g[ready] + 0.5 * np.einsum("kij,kj->ki", H[ready], step))
        whole = size[ready] + np.abs(J[ready])
        last = np.abs(promised) <= DONE * whole
        finished = ready[last]
        x[finished] = tried[last]
        J[finished] -= promised[last]
        ready, tried, promised, whole = ready[~last], tried[~last], promised[~last], whole[~last]
        there = objective(tried, ready)
        good = (promised >= 0) & (J[ready] - there[0] >= WORTH * promised - CALM * whole)
        took = ready[good]
        x[took], J[took], g[took], H[took] = tried[good], there[0][good], there[1][good], there[2][good]
        eased = np.where(damping[took] > FIRST, LOOSE * damping[took], 0.0)
        damping[going] = np.maximum(FIRM * damping[going], FIRST)
        damping[took] = eased
        ending = damping > HOPELESS
        ending[finished] = True
        going = going[~ending[going]]
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
        held = np.where(now < 0, low, np.where(now > 0, high, 0.0))
        step[left], pull, settled[left] = _solved(H[left], g[left], now != 0, held)
        to = np.where(step[left] < low, -1, np.where(step[left] > high, 1, 0))
        to = np.where((now != 0) & (now * pull <= 0), now, np.where(now != 0, 0, to))
        to = np.where(low >= high, -1, to)
        wrong = settled[left] & (to != now).any(axis=1)
        side[left] = to
        left = left[wrong]
        if not len(left):
            break
    settled[left] = False
    return np.clip(step, lower, upper), settled


def _solved(H: Array, g: Array, fixed: Bools, held: Array) -> tuple[Array, Array, Bools]:
    """The free variables' best against the steps of those that are fixed, and the gradient there, (k, n) both.

    By elimination, which tells whether the free variables' part of H is positive definite, (k,).
    """
    n = g.shape[1]
    A = np.empty((len(g), n, n + 1))
    A[:, :, :n] = np.where(fixed[:, :, None] | fixed[:, None, :], 0.0, H)
    A[:, :, n] = np.where(fixed, held, -(g + np.einsum("kij,kj->ki", H, held)))
    np.einsum("kii->ki", A[:, :, :n])[fixed] = 1.0
    positive = np.ones(len(g), dtype=bool)
    for i in range(n):
        bent = ~(A[:, i, i] > 0)
        if bent.any():
            positive &= ~bent
            A[bent] = np.eye(n, n + 1)
        A[:, i, i:] /= A[:, i, None, i]
        A[:, i + 1 :, i:] -= A[:, i + 1 :, i, None] * A[:, None, i, i:]
    step = A[:, :, n]
    for i in range(n - 2, -1, -1):
        step[:, i] -= (A[:, i, i + 1 : n] * step[:, i + 1 :]).sum(axis=1)
    step = np.where(fixed, held, step)
    return step, g + np.einsum("kij,kj->ki", H, step), positive
