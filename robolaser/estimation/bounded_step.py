"""The best step of a quadratic model within bounds, for many models at once."""

import numpy as np

from robolaser.arrays import Array, Bools

EPS = float(np.finfo(np.float64).eps)
ROUNDING = 100.0 * EPS


def bounded_steps(A: Array, g: Array, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Minimise pᵀA p + 2 gᵀp over lower ≤ p ≤ upper, for each of several problems.

    Block principal pivoting (Portugal, Júdice, Vicente 1994): variables go to a bound and come back. All that are on
    the wrong side change at once; should that not end, only the last of them does (Murty's rule).

    Args:
        A: Positive definite, (c, d, d).
        g: (c, d).
        lower: At most 0, (c, d); equal to `upper` where a variable is fixed.
        upper: At least 0, (c, d).

    Returns:
        Steps (c, d), and by how much each lowers its function, (c,).
    """
    d = g.shape[1]
    fixed = lower >= upper
    side = np.where((lower >= 0.0) & (g > 0.0), -1, np.where((upper <= 0.0) & (g < 0.0), 1, 0))
    side[fixed] = -1
    for attempt in range(4 * d):
        step = _solved(A, g, np.where(side < 0, lower, np.where(side > 0, upper, 0.0)), side == 0)
        slope = np.einsum("cij,cj->ci", A, step)
        slack = ROUNDING * (np.einsum("cij,cj->ci", np.abs(A), np.abs(step)) + np.abs(g))
        slope += g
        to = np.where(step < lower, -1, np.where(step > upper, 1, 0))
        to[(side < 0) & (slope >= -slack)] = -1
        to[(side > 0) & (slope <= slack)] = 1
        to[fixed] = -1
        wrong = to != side
        if not wrong.any():
            break
        if attempt >= d:
            wrong &= np.cumsum(wrong[:, ::-1], axis=1)[:, ::-1] == 1
        side = np.where(wrong, to, side)
    step = np.clip(step, lower, upper)
    gain = -np.einsum("ci,ci->c", step, np.einsum("cij,cj->ci", A, step) + 2.0 * g)
    return step, gain


def _solved(A: Array, g: Array, step: Array, free: Bools) -> Array:
    """Steps (c, d) with the best values of the free variables beside those of the others."""
    if free.all():
        return np.asarray(np.linalg.solve(A, -g[..., None])[..., 0])
    right = -(g + np.einsum("cij,cj->ci", A, step))
    inner = np.where(free[:, :, None] & free[:, None, :], A, np.eye(A.shape[1]))
    return np.asarray(np.where(free, np.linalg.solve(inner, np.where(free, right, 0.0)[..., None])[..., 0], step))
