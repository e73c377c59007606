"""Residuals in blocks of rows: of each, what all candidates cost, its slopes, and how it bends along a step."""

from collections.abc import Callable
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.estimation.differences import BATCH, EPS, Around, Residuals, evaluated
from robolaser.estimation.r_factor import triangle
from robolaser.estimation.robust_loss import AXES, Loss

KEPT = 4_000_000
"""Numbers that slopes may have to be kept: beyond the processor's cache they are worked out again as quickly."""
PROBE = 0.1
"""Share of a step at which its curvature is measured."""


@final
class Rows:
    """The residuals of a problem, evaluated a block and some candidates at a time.

    Args:
        blocks: Each takes candidates (c, d) to residuals (c, k), with a k of its own.
        loss: What they cost.
        x: A candidate to begin with, (d,).

    Attributes:
        cost: At that candidate.
        evaluations: Candidates evaluated so far.
    """

    def __init__(self, blocks: tuple[Callable[[Array], Array], ...], loss: Loss, x: Array) -> None:
        first = [evaluated(residuals, x[None]) for residuals in blocks]
        self._blocks, self._loss = blocks, loss
        self._numbers = [e.shape[1] for e in first]
        self._slopes = self._room_for_slopes(len(x) + 1)
        self.cost = float(sum(loss.costs(e)[0] for e in first))
        self.evaluations = 1

    def _room_for_slopes(self, rows: int) -> list[Array]:
        """Of each block, (rows, k); none where they would be too many to be kept."""
        if rows * sum(self._numbers) > KEPT:
            return []
        whole = np.empty(rows * sum(self._numbers))
        return [part.reshape(rows, -1) for part in np.split(whole, rows * np.cumsum(self._numbers)[:-1])]

    def batches(self, candidates: int) -> list[slice]:
        """Candidates to be evaluated together: all where there are few residuals."""
        at_once = max(1, BATCH // max(1, sum(self._numbers)))
        return [slice(start, start + at_once) for start in range(0, candidates, at_once)]

    def costs(self, candidates: Array) -> Array:
        """Costs of candidates, (c, d) -> (c,)."""
        self.evaluations += len(candidates)
        costs = np.zeros(len(candidates))
        for residuals in self._blocks:
            costs += self._loss.costs(evaluated(residuals, candidates))
        return costs

    def around(self, at: Around) -> tuple[Array, float]:
        """Triangle of derivatives by scaled variables and residuals, (d + 1 or less, d + 1), and the rounding error.

        That is the smallest cost that residuals can have by chance when each variable is known to its last digit.
        """
        R, rounding = np.empty((0, len(at.x) + 1)), 0.0
        digits = EPS * np.abs(at.x / at.scale)
        for block in range(len(self._blocks)):
            slopes = self._slopes_of(block, at)
            R = triangle(triangle(self._loss.straightened(slopes).T), R)
            rounding += float(np.sum((digits @ np.abs(slopes[:-1])) ** 2))
        self.evaluations += at.evaluations
        return R, rounding

    def _slopes_of(self, block: int, at: Around) -> Array:
        return at.slopes(self._blocks[block], self._numbers[block], self._slopes[block] if self._slopes else None)

    def bends(self, at: Around, steps: Array) -> Array:
        """Where the rows' second derivatives along scaled steps (c, d) pull: JᵀE'' for each, (c, d).

        Zero for a step along which a residual is not finite.
        """
        probes, pull = at.moved(PROBE * steps), np.zeros_like(steps)
        for block, residuals in enumerate(self._blocks):
            slopes = self._slopes[block] if self._slopes else self._slopes_of(block, at)
            pull += bends_along(residuals, self._loss, slopes, steps, probes) @ slopes[:-1].T
        self.evaluations += len(steps) + (0 if self._slopes else at.evaluations)
        return np.where(np.isfinite(pull).all(axis=1, keepdims=True), pull, 0.0)


def bends_along(residuals: Residuals, loss: Loss, slopes: Array, steps: Array, probes: Array) -> Array:
    """Second derivatives along steps, (c, d) -> (c, k), each row by its share in the cost.

    Args:
        residuals: Candidates (c, d) to (c, k).
        loss: What residuals cost.
        slopes: Their derivatives by scaled variables, themselves as the last row, (d + 1, k).
        steps: Scaled, (c, d).
        probes: Candidates at the share `PROBE` of each step, (c, d).
    """
    bends = evaluated(residuals, probes)
    bends -= slopes[-1]
    bends -= PROBE * steps @ slopes[:-1]
    bends *= 2.0 / PROBE**2
    if loss.name != "square":
        bends *= loss.shares(slopes[-1:]).repeat(AXES, axis=1)
    return bends
