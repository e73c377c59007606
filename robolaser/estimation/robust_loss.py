"""The cost of a row of residuals: its square or, where some rows may be gross errors, less for the large ones.

A row has one or more numbers; with z = |e|²/s² it costs s² log(1 + z), Cauchy's loss of scale s. Black, Anandan 1996.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints

LEAST_CURVATURE = 0.01
"""Least curvature of the loss along a residual, relative to its slope: beyond the scale it is negative, and steps
towards a saddle would not descend."""


@final
@dataclass(frozen=True)
class Loss:
    """A loss with its scale; residuals are flat, (c, K), each row's numbers begin at `starts` (m,)."""

    scale: float = np.inf  # length s above which a row counts for less; infinite: rows cost their squares

    @property
    def is_square(self) -> bool:
        """Whether rows cost their squares."""
        return self.scale == np.inf

    def costs(self, residuals: Array, starts: Ints) -> Array:
        """Cost of all rows of each candidate, (c, K) -> (c,); infinite where one is not finite."""
        with np.errstate(over="ignore", invalid="ignore"):
            if self.is_square:
                costs = np.einsum("ck,ck->c", residuals, residuals)
            else:
                costs = self.scale**2 * np.log1p(self._z(residuals, starts)).sum(axis=-1)
        return np.where(np.isfinite(costs), costs, np.inf)

    def weights(self, residuals: Array, starts: Ints) -> Array:
        """Weight of each row, (c, K) -> (c, m): 1 for small ones."""
        return 1.0 / (1.0 + self._z(residuals, starts))

    def linearized(self, residuals: Array, J: Array, starts: Ints) -> tuple[Array, Array]:
        """Residuals and derivatives whose squares have the cost's gradient and, where it curves upward, its curvature.

        Triggs, McLauchlan, Hartley, Fitzgibbon 2000, Bundle adjustment: a modern synthesis, eq. 11.

        Args:
            residuals: (c, K).
            J: (c, d, K).
            starts: (m,).
        """
        if self.is_square:
            return residuals, J
        z, slope = self._z(residuals, starts), self.weights(residuals, starts)
        bend = -1.0 / (1.0 + z) ** 2
        shrink = np.sqrt(np.maximum(1.0 + 2.0 * z * bend / slope, LEAST_CURVATURE))  # 1 - α
        length = np.sqrt(np.maximum(z, np.finfo(np.float64).tiny)) * self.scale
        away = residuals / of_numbers(length, residuals, starts)
        along = np.add.reduceat(J * away[:, None], starts, axis=-1)
        root = of_numbers(np.sqrt(slope), residuals, starts)
        straight = J - of_numbers((1.0 - shrink)[:, None] * along, residuals, starts) * away[:, None]
        return root * residuals / of_numbers(shrink, residuals, starts), root[:, None] * straight

    def _z(self, residuals: Array, starts: Ints) -> Array:
        return np.add.reduceat(residuals**2, starts, axis=-1) / self.scale**2


def of_numbers(of_rows: Array, residuals: Array, starts: Ints) -> Array:
    """Values of rows, (..., m), repeated for each of their numbers, (..., K)."""
    return np.repeat(of_rows, np.diff(starts, append=residuals.shape[1]), axis=-1)


SQUARE = Loss()
