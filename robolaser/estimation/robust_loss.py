"""What a row of residuals costs: its square or, where some rows may be gross errors, less for the large ones.

A row has one or more numbers; with z = |e|²/s² it costs s² ρ(z), as in SciPy's `least_squares`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.errors import UsageError

LEAST_CURVATURE = 0.01
"""Of ρ along a residual, relative to its slope, at the least: beyond the scale both losses curve the other way there,
and steps towards a saddle would not lead down."""


def _huber(z: Array) -> tuple[Array, Array, Array]:
    far = np.sqrt(np.maximum(z, 1.0))
    return np.where(z <= 1.0, z, 2.0 * far - 1.0), 1.0 / far, np.where(z <= 1.0, 0.0, -0.5 / far**3)


def _cauchy(z: Array) -> tuple[Array, Array, Array]:
    return np.log1p(z), 1.0 / (1.0 + z), -1.0 / (1.0 + z) ** 2


LOSSES: Mapping[str, Callable[[Array], tuple[Array, Array, Array]] | None] = {
    "square": None,
    "huber": _huber,
    "cauchy": _cauchy,
}
"""ρ, its first and its second derivative by z, by name; Huber 1964, Black and Anandan 1996."""

EFFICIENT: Mapping[str, float] = {"huber": 1.345, "cauchy": 2.385}
"""Scales, in standard deviations, at which 5 % of the efficiency is lost where all errors are normal and lie along a
line, as a scanner's nearly do; less is lost where they lie all around."""
MEDIAN = 0.6745  # median length of such errors, in standard deviations
HALF = 0.5  # weight of a row below which it counts as a gross error


@final
@dataclass(frozen=True)
class Loss:
    """A loss with its scale.

    Residuals are flat, (c, K); `starts` (m,) says where each row's numbers begin.

    Attributes:
        name: One of `LOSSES`.
        scale: Length s of a row from which on it counts for less, in the unit of the residuals.

    Raises:
        UsageError: There is no loss of that name.
    """

    name: str = "square"
    scale: float = 1.0

    def __post_init__(self) -> None:
        if self.name not in LOSSES:
            raise UsageError(f"There is no loss {self.name!r}. There are: {', '.join(LOSSES)}.")

    @property
    def is_square(self) -> bool:
        """Whether rows cost their squares."""
        return LOSSES[self.name] is None

    @classmethod
    def fitting(cls, name: str, residuals: Array, starts: Ints) -> "Loss":
        """The loss of that name with a scale from the median length of rows: few gross errors do not move it.

        Args:
            name: One of `LOSSES`.
            residuals: (K,).
            starts: (m,).

        Raises:
            UsageError: There is no loss of that name.
        """
        if name not in EFFICIENT:
            return cls(name)
        median = float(np.median(np.sqrt(np.add.reduceat(residuals**2, starts))))
        return cls(name, max(EFFICIENT[name] * median / MEDIAN, float(np.finfo(np.float64).tiny)))

    def costs(self, residuals: Array, starts: Ints) -> Array:
        """Cost of all rows of each candidate, (c, K) -> (c,); infinite where one is not finite."""
        rho = LOSSES[self.name]
        with np.errstate(over="ignore", invalid="ignore"):
            if rho is None:
                costs = np.einsum("ck,ck->c", residuals, residuals)
            else:
                costs = self.scale**2 * rho(self._z(residuals, starts))[0].sum(axis=-1)
        return np.where(np.isfinite(costs), costs, np.inf)

    def weights(self, residuals: Array, starts: Ints) -> Array:
        """Weight of each row, ρ', (c, K) -> (c, m): 1 for small ones."""
        rho = LOSSES[self.name]
        return np.ones((len(residuals), len(starts))) if rho is None else rho(self._z(residuals, starts))[1]

    def linearized(self, residuals: Array, J: Array, starts: Ints) -> tuple[Array, Array]:
        """Residuals and derivatives whose squares have the cost's gradient and, where it curves upward, its curvature.

        Triggs, McLauchlan, Hartley, Fitzgibbon 2000, Bundle adjustment: a modern synthesis, eq. 11.

        Args:
            residuals: (c, K).
            J: (c, d, K).
            starts: (m,).
        """
        rho = LOSSES[self.name]
        if rho is None:
            return residuals, J
        _, slope, bend = rho(z := self._z(residuals, starts))
        shrink = np.sqrt(np.maximum(1.0 + 2.0 * z * bend / slope, LEAST_CURVATURE))  # 1 - α

        def of_numbers(of_rows: Array) -> Array:
            return _of_numbers(of_rows, residuals, starts)

        length = np.sqrt(np.maximum(z, np.finfo(np.float64).tiny)) * self.scale
        away = residuals / of_numbers(length)
        along = np.add.reduceat(J * away[:, None], starts, axis=-1)
        root = of_numbers(np.sqrt(slope))
        straight = J - of_numbers((1.0 - shrink)[:, None] * along) * away[:, None]
        return root * residuals / of_numbers(shrink), root[:, None] * straight

    def _z(self, residuals: Array, starts: Ints) -> Array:
        return np.add.reduceat(residuals**2, starts, axis=-1) / self.scale**2


def _of_numbers(of_rows: Array, residuals: Array, starts: Ints) -> Array:
    """What each row has, (..., m), for each of its numbers, (..., K)."""
    return np.repeat(of_rows, np.diff(starts, append=residuals.shape[1]), axis=-1)


SQUARE = Loss()
