"""Derivatives of residuals by central differences, many candidates in one batch."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import ResidualsShape

EPS = float(np.finfo(np.float64).eps)
STEP = EPS ** (1 / 3)
"""Of a central difference, in units of the scale: where its two errors, curvature and rounding, are equal."""
BATCH = 4_000_000
"""Numbers that a batch of candidates may have: 32 MB."""

Residuals = Callable[[Array], Array]
"""Candidates (c, d) to their residuals (c, k)."""


@final
@dataclass(frozen=True)
class Around:
    """A point within bounds, and where differences around it are taken: all (d,).

    Attributes:
        x: The point.
        lower: Lower bounds.
        upper: Upper bounds; equal to the lower for variables without room.
        scale: A typical change of each variable.
    """

    x: Array
    lower: Array
    upper: Array
    scale: Array

    @property
    def room(self) -> tuple[Array, Array]:
        """How far scaled steps may go down and up, (d,) each."""
        return (self.lower - self.x) / self.scale, (self.upper - self.x) / self.scale

    @property
    def evaluations(self) -> int:
        """Candidates that slopes ask for."""
        return 1 + 2 * int((self.upper > self.lower).sum())

    def slopes(self, residuals: Residuals, rows: int, out: Array | None = None) -> Array:
        """Derivatives of so many residuals by the scaled variables, themselves as the last row, (d + 1, rows).

        By three points: two and x, one on each side of it or, at a bound, both on the inner. The row of a variable
        without room is zero.
        """
        x, lower, upper, scale = self.x, self.lower, self.upper, self.scale
        moving = np.flatnonzero(upper > lower)
        step = np.minimum(np.maximum(STEP * scale, STEP**2 * np.abs(x)), (upper - lower) / 4.0)[moving]
        above, below = (upper - x)[moving] >= step, (x - lower)[moving] >= step
        near = np.where(above, step, -step)
        far = np.where(above & below, -step, 2.0 * near)

        pairs = np.tile(x, (len(moving), 2, 1))
        every = np.arange(len(moving))
        pairs[every, 0, moving] += near
        pairs[every, 1, moving] += far
        pairs = np.clip(pairs, lower, upper)
        to_near, to_far = ((pairs[every, :, moving] - x[moving, None]) / scale[moving, None]).T.tolist()

        at_once = max(1, BATCH // (2 * rows))
        slopes = np.empty((len(x) + 1, rows)) if out is None else out
        slopes[np.flatnonzero(upper <= lower)] = 0.0
        for start in range(0, max(1, len(moving)), at_once):
            some = slice(start, start + at_once)
            points = pairs[some].reshape(-1, len(x))
            e = evaluated(residuals, points if start else np.concatenate([x[None], points]))
            if not start:
                slopes[-1], e = e[0], e[1:]
            for j, near_e, far_e, h, g in zip(moving[some], e[::2], e[1::2], to_near[some], to_far[some], strict=True):
                _three_point(near_e, far_e, slopes[-1], h, g, out=slopes[j])
        return slopes

    def moved(self, steps: Array) -> Array:
        """Candidates after scaled steps (c, d); one up to a bound ends exactly on it."""
        down, up = self.room
        inside = np.clip(self.x + self.scale * steps, self.lower, self.upper)
        inside = np.where(steps >= up, self.upper, inside)
        return np.asarray(np.where(steps <= down, self.lower, inside))


def _three_point(near: Array, far: Array, r: Array, to_near: float, to_far: float, *, out: Array) -> None:
    """A derivative (k,) from residuals at a near and a far point and r; from one of them where the other fails."""
    good_near, good_far = np.isfinite(near.sum()), np.isfinite(far.sum())
    if not good_near:
        to_near, near = to_far, far if good_far else r
    elif not good_far:
        to_far, far = to_near, near
    if not (good_near and good_far):
        np.subtract(near, r, out=out)
        out /= to_near
    elif to_near == -to_far:
        np.subtract(near, far, out=out)
        out /= 2.0 * to_near
    else:
        np.subtract(near, r, out=out)
        out *= to_far / to_near
        out -= (far - r) * (to_near / to_far)
        out /= to_far - to_near


def evaluated(residuals: Residuals, candidates: Array) -> Array:
    """Residuals of candidates, (c, d) -> (c, k).

    Raises:
        ResidualsShape: There is not one row for each candidate.
    """
    rows = np.asarray(residuals(candidates), np.float64)
    if rows.ndim != 2 or len(rows) != len(candidates):
        raise ResidualsShape(len(candidates), rows.shape)
    return rows
