"""The best step of a quadratic model within bounds, for many models at once."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints

EPS = float(np.finfo(np.float64).eps)
ROUNDING = 100.0 * EPS


def bounded_steps(
    A: Array, g: Array, lower: Array, upper: Array, side: Ints | None = None
) -> tuple[Array, Array, Ints]:
    """Minimise pᵀA p + 2 gᵀp over lower ≤ p ≤ upper, for each of several problems.

    Block principal pivoting (Portugal, Júdice, Vicente 1994): variables move to a bound and back. All that are on the
    wrong side change at once; if that does not end, only the last one changes (Murty's rule).

    Args:
        A: Positive definite, (c, d, d).
        g: (c, d).
        lower: At most 0, (c, d); equal to `upper` where a variable is fixed.
        upper: At least 0, (c, d).
        side: Bounds at which the step of a similar problem ends, (c, d), where it is known: -1 lower, 1 upper, 0 none.

    Returns:
        Steps (c, d), by how much each lowers its function, (c,), and at which bounds it ends, (c, d).
    """
    d = g.shape[1]
    fixed, size = lower >= upper, np.abs(A)
    pressed = np.where((lower >= 0.0) & (g > 0.0), -1, np.where((upper <= 0.0) & (g < 0.0), 1, 0))
    side = pressed if side is None else np.where(pressed == 0, side, pressed)
    side[fixed] = -1
    steps = np.zeros_like(g)
    left = np.arange(len(g))
    for attempt in range(4 * d):
        at, low, high = side[left], lower[left], upper[left]
        step = _solved(A[left], g[left], np.where(at < 0, low, np.where(at > 0, high, 0.0)), at == 0)
        steps[left] = step
        slope = np.einsum("cij,cj->ci", A[left], step)
        slack = ROUNDING * (np.einsum("cij,cj->ci", size[left], np.abs(step)) + np.abs(g[left]))
        slope += g[left]
        to = np.where(step < low, -1, np.where(step > high, 1, 0))
        to[(at < 0) & (slope >= -slack)] = -1
        to[(at > 0) & (slope <= slack)] = 1
        to[fixed[left]] = -1
        wrong = to != at
        if attempt >= d:
            wrong &= np.cumsum(wrong[:, ::-1], axis=1)[:, ::-1] == 1
        side[left] = np.where(wrong, to, at)
        left = left[wrong.any(axis=1)]
        if not len(left):
            break
    steps = np.clip(steps, lower, upper)
    gain = -np.einsum("ci,ci->c", steps, np.einsum("cij,cj->ci", A, steps) + 2.0 * g)
    return steps, gain, side


def _solved(A: Array, g: Array, step: Array, free: Bools) -> Array:
    """Steps (c, d) with the best values of the free variables, the others given."""
    if free.all():
        return np.asarray(np.linalg.solve(A, -g[..., None])[..., 0])
    right = -(g + np.einsum("cij,cj->ci", A, step))
    inner = np.where(free[:, :, None] & free[:, None, :], A, np.eye(A.shape[1]))
    return np.asarray(np.where(free, np.linalg.solve(inner, np.where(free, right, 0.0)[..., None])[..., 0], step))
