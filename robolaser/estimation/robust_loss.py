"""What a residual costs: its square or, where some points may be wrong altogether, less for the large ones.

A residual is the vector of a row, three numbers. With z = |e|²/s² its cost is s² ρ(z), as in SciPy's `least_squares`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import LossUnknown

AXES = 3
"""Numbers of a row."""
LEAST_CURVATURE = 0.01
"""Of ρ along a residual, relative to its slope, at the least: beyond the scale both losses perturb the other way there,
and steps towards a saddle would be no steps down."""


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
MEDIAN = 0.6745
"""Median length of such errors, in standard deviations."""


@final
@dataclass(frozen=True)
class Loss:
    """A loss with its scale.

    Attributes:
        name: One of `LOSSES`.
        scale: Length s of a residual from which it counts for less, in the unit of the residuals.
    """

    name: str = "square"
    scale: float = 1.0

    def __post_init__(self) -> None:
        if self.name not in LOSSES:
            raise LossUnknown(self.name, LOSSES)

    @classmethod
    def fitting(cls, name: str, residuals: Array) -> "Loss":
        """The loss of that name with a scale from the median length of residuals (m, 3): few gross ones do not move it.

        Raises:
            LossUnknown: There is none of that name.
        """
        if name not in EFFICIENT:
            return cls(name)
        median = float(np.median(np.linalg.norm(residuals, axis=-1)))
        return cls(name, max(EFFICIENT[name] * median / MEDIAN, float(np.finfo(np.float64).tiny)))

    def costs(self, rows: Array) -> Array:
        """Cost of all residuals of each candidate, (c, 3m) -> (c,); infinite where one is not finite."""
        rho = LOSSES[self.name]
        with np.errstate(over="ignore", invalid="ignore"):
            if rho is None:
                costs = np.einsum("ck,ck->c", rows, rows)
            else:
                costs = self.scale**2 * rho(self._lengths2(rows) / self.scale**2)[0].sum(axis=-1)
        return np.where(np.isfinite(costs), costs, np.inf)

    def shares(self, rows: Array) -> Array:
        """By how much each residual counts, ρ', (c, 3m) -> (c, m): 1 for small ones."""
        rho = LOSSES[self.name]
        z = self._lengths2(rows) / self.scale**2
        return np.ones_like(z) if rho is None else rho(z)[1]

    def straightened(self, rows: Array) -> Array:
        """Derivatives with the residuals as the last row, (d + 1, 3m), as squares would have them.

        Their squares have the gradient of the cost and, as far as it curves upward, its curvature. Triggs, McLauchlan,
        Hartley, Fitzgibbon 2000, Bundle adjustment: a modern synthesis, eq. 11.
        """
        rho = LOSSES[self.name]
        if rho is None:
            return rows
        lengths2 = self._lengths2(rows[-1:])[0]
        _, slope, perturb = rho(lengths2 / self.scale**2)
        curvature = 1.0 + 2.0 * lengths2 / self.scale**2 * perturb / slope
        shrink = np.sqrt(np.maximum(curvature, LEAST_CURVATURE))  # 1 - α
        vectors = rows.reshape(len(rows), -1, AXES)
        away = vectors[-1] / np.sqrt(np.maximum(lengths2, np.finfo(np.float64).tiny))[:, None]
        along = np.einsum("dma,ma->dm", vectors, away)
        straight = vectors - ((1.0 - shrink) * along)[..., None] * away
        straight[-1] = vectors[-1] / shrink[:, None]
        found: Array = (np.sqrt(slope)[:, None] * straight).reshape(rows.shape)
        return found

    def _lengths2(self, rows: Array) -> Array:
        vectors = rows.reshape(len(rows), -1, AXES)
        lengths2: Array = np.einsum("cma,cma->cm", vectors, vectors)
        return lengths2
