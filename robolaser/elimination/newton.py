"""Newton's method within bounds, for many small problems at once."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools, Ints

STEPS = 60  # ten are usual
CALM = 1e-14  # of a problem's size: sums of squares of that size differ by this from one rounding to the next
DONE = 1e-26  # of the same: a step that promises less changes nothing any more
FIRST = 1e-3  # damping once a step has failed, in units of the curvature's diagonal
FIRM, LOOSE = 8.0, 0.2  # the damping after a step that failed, and after one that did what it promised

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
        diagonal = np.abs(np.einsum("kii->ki", H[going])) + np.finfo(float).tiny
        curved = H[going].copy()
        np.einsum("kii->ki", curved)[:] += damping[going, None] * diagonal
        step = _boxed(curved, g[going], low - at, high - at)
        promised = -np.einsum("ki,ki->k", step, g[going] + 0.5 * np.einsum("kij,kj->ki", H[going], step))
        tried = np.clip(at + step, low, high)
        there = objective(tried, going)
        gained = J[going] - there[0]
        noise = CALM * size[going]
        good = (promised > 0) & (gained >= 1e-3 * promised - noise)
        took = going[good]
        x[took], J[took], g[took], H[took] = tried[good], there[0][good], there[1][good], there[2][good]
        damping[going] = np.where(good, LOOSE * damping[going], np.maximum(FIRM * damping[going], FIRST))
        damping[damping < FIRST * LOOSE**2] = 0.0
        still = (np.abs(promised) <= DONE * size[going]) | (damping[going] > 1e9)
        going = going[~still]
    return x, J


def _boxed(H: Array, g: Array, lower: Array, upper: Array) -> Array:
    """Steps that minimise g·s + s·H·s/2 with s in a box; variables that run into a bound stay there, (k, n)."""
    fixed = ((lower >= 0) & (g > 0)) | ((upper <= 0) & (g < 0)) | (lower >= upper)
    step = np.zeros_like(g)
    open_ = np.arange(len(g))
    for _ in range(g.shape[1] + 1):
        step[open_] = _solved(H[open_], g[open_], fixed[open_], step[open_])
        over = ~fixed[open_] & ((step[open_] < lower[open_]) | (step[open_] > upper[open_]))
        hit = over.any(axis=1)
        if not hit.any():
            break
        open_ = open_[hit]
        fixed[open_] |= over[hit]
        step[open_] = np.clip(step[open_], lower[open_], upper[open_])
    return step


def _solved(H: Array, g: Array, fixed: Bools, step: Array) -> Array:
    """The free variables' best against the fixed ones' steps; all of them together, (k, n)."""
    held = np.where(fixed, step, 0.0)
    right = np.where(fixed, held, -(g + np.einsum("kij,kj->ki", H, held)))
    A = np.where(fixed[:, :, None] | fixed[:, None, :], 0.0, H)
    np.einsum("kii->ki", A)[fixed] = 1.0
    try:
        found: Array = np.linalg.solve(A, right[..., None])[..., 0]
    except np.linalg.LinAlgError:
        found = (np.linalg.pinv(A, hermitian=True) @ right[..., None])[..., 0]
    return np.where(fixed, held, found)
