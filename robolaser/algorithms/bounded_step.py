"""The best step that a linear model of the residuals promises, no longer than the bounds allow."""

import numpy as np

from robolaser.arrays import Array, Ints


def bounded_steps(J: Array, r: Array, lower: Array, upper: Array, dampings: Array, noise: float) -> tuple[Array, Array]:
    """Minimise |J p + r|² + μ |p|² over lower ≤ p ≤ upper, for each damping.

    Args:
        J: Jacobian, (k, d).
        r: Residuals, (k,); or others for each damping, (c, k).
        lower: Lower bounds of the step, (d,), at most 0.
        upper: Upper bounds of the step, (d,), at least 0.
        dampings: μ in units of the square of J's largest singular value, (c,).
        noise: Singular values below this share of the largest count as 0; the step has no part along them.

    Returns:
        Steps (c, d), and by how much each lowers |J p + r|², (c,).
    """
    Q, R = np.linalg.qr(J) if len(J) > J.shape[1] else (np.eye(len(J)), J)
    c = np.broadcast_to(r @ Q, (len(dampings), len(R)))
    solver = _Solver(R, noise)
    steps = np.array(
        [
            _bounded_step(solver, rest, lower, upper, damping * solver.largest**2)
            for rest, damping in zip(c, dampings, strict=True)
        ]
    )
    ahead = steps @ R.T + c
    return steps, np.einsum("ck,ck->c", c, c) - np.einsum("ck,ck->c", ahead, ahead)


class _Solver:
    """Damped least squares over subsets of the variables, each taken apart once."""

    def __init__(self, R: Array, noise: float) -> None:
        self.R = R
        self._parts: dict[bytes, tuple[Array, Array, Array]] = {}
        _, s, _ = self._part(np.arange(R.shape[1]))
        self.largest = float(s.max(initial=0.0))
        self._floor = noise * self.largest

    def _part(self, free: Ints) -> tuple[Array, Array, Array]:
        key = free.tobytes()
        if key not in self._parts:
            U, s, Vt = np.linalg.svd(self.R[:, free], full_matrices=False)
            self._parts[key] = U, s, Vt
        return self._parts[key]

    def solve(self, free: Ints, rest: Array, damping: float) -> Array:
        """Best values of the free variables against what the others leave, (m,)."""
        U, s, Vt = self._part(free)
        seen = s > self._floor
        step: Array = -Vt[seen].T @ (s[seen] / (s[seen] ** 2 + damping) * (U.T @ rest)[seen])
        return step


def _bounded_step(solver: _Solver, c: Array, lower: Array, upper: Array, damping: float) -> Array:
    """Block principal pivoting (Portugal, Júdice, Vicente 1994): variables go to a bound and come back.

    All that are on the wrong side change at once. Should that not end, as it may if J has not full rank, only the
    last of them does (Murty's rule).
    """
    R = solver.R
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
