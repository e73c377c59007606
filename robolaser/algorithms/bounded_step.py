"""The best step that a linear model of the residuals promises, no longer than the bounds allow."""

import numpy as np

from robolaser.arrays import Array, Ints


def bounded_steps(J: Array, r: Array, lower: Array, upper: Array, dampings: Array, noise: float) -> tuple[Array, Array]:
    """Minimise |J p + r|² + μ |p|² over lower ≤ p ≤ upper, for each damping.

    Args:
        J: Jacobian, (k, d).
        r: Residuals, (k,).
        lower: Lower bounds of the step, (d,), at most 0.
        upper: Upper bounds of the step, (d,), at least 0.
        dampings: μ in units of the square of J's largest singular value, (c,).
        noise: Singular values below this share of the largest count as 0; the step has no part along them.

    Returns:
        Steps (c, d), and by how much each lowers |J p + r|², (c,).
    """
    Q, R = np.linalg.qr(J)
    c = Q.T @ r
    largest = float(np.linalg.norm(R, 2)) if R.size else 0.0
    solver = _Solver(R, c, noise * largest)
    steps = np.array([_bounded_step(solver, lower, upper, damping * largest**2) for damping in dampings])
    ahead = steps @ R.T + c
    return steps, c @ c - np.einsum("ck,ck->c", ahead, ahead)


class _Solver:
    """Damped least squares over subsets of the variables, each taken apart once."""

    def __init__(self, R: Array, c: Array, floor: float) -> None:
        self.R, self.c, self.floor = R, c, floor
        self._parts: dict[bytes, tuple[Array, Array, Array]] = {}

    def solve(self, free: Ints, rest: Array, damping: float) -> Array:
        """Best values of the free variables against what the others leave, (m,)."""
        key = free.tobytes()
        if key not in self._parts:
            U, s, Vt = np.linalg.svd(self.R[:, free], full_matrices=False)
            seen = s > self.floor
            self._parts[key] = U[:, seen], s[seen], Vt[seen]
        U, s, Vt = self._parts[key]
        step: Array = -Vt.T @ (s / (s**2 + damping) * (U.T @ rest))
        return step


def _bounded_step(solver: _Solver, lower: Array, upper: Array, damping: float) -> Array:
    """Block principal pivoting (Portugal, Júdice, Vicente 1994): variables go to a bound and come back.

    All that are on the wrong side change at once. Should that not end, as it may if J has not full rank, only the
    last of them does (Murty's rule).
    """
    R, c = solver.R, solver.c
    d = R.shape[1]
    eps = np.finfo(np.float64).eps
    gradient = R.T @ c
    side = np.where((lower >= 0.0) & (gradient > 0.0), -1, np.where((upper <= 0.0) & (gradient < 0.0), 1, 0))
    side[lower >= upper] = -1
    step = np.zeros(d)
    for attempt in range(4 * d):
        free = np.flatnonzero(side == 0)
        step = np.where(side < 0, lower, np.where(side > 0, upper, 0.0))
        step[free] = solver.solve(free, c + R @ step, damping)

        ahead = R @ step + c
        gradient = R.T @ ahead + damping * step
        slack = 100.0 * eps * (np.abs(R.T) @ (np.abs(R) @ np.abs(step) + np.abs(c)))
        to = np.where(step < lower, -1, np.where(step > upper, 1, 0))
        to[(side < 0) & (gradient >= -slack)] = -1
        to[(side > 0) & (gradient <= slack)] = 1
        to[lower >= upper] = -1
        wrong = np.flatnonzero(to != side)
        if len(wrong) == 0:
            break
        changing = wrong if attempt < d else wrong[-1:]
        side[changing] = to[changing]
    return np.clip(step, lower, upper)
