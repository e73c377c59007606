"""The best step that a linear model of the residuals promises, no longer than the bounds allow."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
class Linear:
    """A linear model of residuals, |J p + r|², taken apart once for many steps.

    Args:
        J: Jacobian, (k, d); a triangle costs less.
        noise: Singular values below this share of the largest count as 0; steps have no part along them.
    """

    def __init__(self, J: Array, noise: float) -> None:
        k, d = J.shape
        if k <= d or not np.tril(J, -1).any():
            self._Q, self.R = np.eye(k, min(k, d)), J[:d]
        else:
            self._Q, self.R = np.linalg.qr(J)
        self._parts: dict[bytes, tuple[Array, Array, Array]] = {}
        _, s, _ = self._part(np.arange(d))
        self.largest = float(s.max(initial=0.0))
        self._floor = noise * self.largest

    def steps(self, r: Array, lower: Array, upper: Array, dampings: Array) -> tuple[Array, Array]:
        """Minimise |J p + r|² + μ |p|² over lower ≤ p ≤ upper, for each damping.

        Args:
            r: Residuals, (k,); or others for each damping, (c, k).
            lower: Lower bounds of the step, (d,), at most 0.
            upper: Upper bounds of the step, (d,), at least 0.
            dampings: μ in units of the square of J's largest singular value, (c,).

        Returns:
            Steps (c, d), and by how much each lowers |J p + r|², (c,).
        """
        c = np.broadcast_to(r @ self._Q, (len(dampings), len(self.R)))
        steps = np.array(
            [
                _bounded_step(self, rest, lower, upper, damping * self.largest**2)
                for rest, damping in zip(c, dampings, strict=True)
            ]
        )
        ahead = steps @ self.R.T + c
        return steps, np.einsum("ck,ck->c", c, c) - np.einsum("ck,ck->c", ahead, ahead)

    def pulling(self, pulls: Array) -> Array:
        """The shortest residuals e with Jᵀ e = pulls, as far as J sees them, (c, d) -> (c, k)."""
        U, s, Vt = self._part(np.arange(self.R.shape[1]))
        seen = s > self._floor
        e: Array = (pulls @ Vt[seen].T / s[seen]) @ (self._Q @ U[:, seen]).T
        return e

    def solve(self, free: Ints, rest: Array, damping: float) -> Array:
        """Best values of the free variables against what the others leave, (m,)."""
        U, s, Vt = self._part(free)
        seen = s > self._floor
        step: Array = -Vt[seen].T @ (s[seen] / (s[seen] ** 2 + damping) * (U.T @ rest)[seen])
        return step

    def _part(self, free: Ints) -> tuple[Array, Array, Array]:
        key = free.tobytes()
        if key not in self._parts:
            U, s, Vt = np.linalg.svd(self.R[:, free], full_matrices=False)
            self._parts[key] = U, s, Vt
        return self._parts[key]


def _bounded_step(model: Linear, c: Array, lower: Array, upper: Array, damping: float) -> Array:
    """Block principal pivoting (Portugal, Júdice, Vicente 1994): variables go to a bound and come back.

    All that are on the wrong side change at once. Should that not end, as it may if J has not full rank, only the
    last of them does (Murty's rule).
    """
    R = model.R
    d = R.shape[1]
    eps = np.finfo(np.float64).eps
    gradient = R.T @ c
    side = np.where((lower >= 0.0) & (gradient > 0.0), -1, np.where((upper <= 0.0) & (gradient < 0.0), 1, 0))
    side[lower >= upper] = -1
    step = np.zeros(d)
    for attempt in range(4 * d):
        free = np.flatnonzero(side == 0)
        step = np.where(side < 0, lower, np.where(side > 0, upper, 0.0))
        step[free] = model.solve(free, c + R @ step, damping)

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
