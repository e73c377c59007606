"""Where a polish may go: the bounds, with held parameters closed, and the residuals that it sees."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.algorithms.gauss_newton import Polished, gauss_newton
from robolaser.arrays import Array, Bools
from robolaser.noise import NoiseModel
from robolaser.scanner import Model

MOST_STEPS = 3000  # few points leave long bent valleys: 200 steps were needed along one, 20 are usual


@final
@dataclass(frozen=True)
class Residuals:
    """Residuals as one row for each candidate, (c, d) -> (c, 3 m); whitened where a noise model is given."""

    model: Model
    noise: NoiseModel | None = None

    def __call__(self, x: Array) -> Array:
        """All rows, three numbers each."""
        rows = self.model.residuals(x).reshape(len(x), -1)
        return rows if self.noise is None else self.noise.whiten(rows)


@final
@dataclass(frozen=True)
class Box:
    """Bounds of a model's parameters, (d,) each, those of held parameters closed.

    Attributes:
        lower: Lower bounds.
        upper: Upper bounds.
        scale: A typical change of each parameter: the distance of its bounds.
        held: Parameters that the gauge holds at their nominal values.
    """

    lower: Array
    upper: Array
    scale: Array
    held: Bools

    @classmethod
    def of(cls, model: Model) -> "Box":
        """The bounds of the data set, with the gauge fixed."""
        parameters = model.parameters
        held = np.isin(parameters.names, model.sensor.held)
        lower = np.where(held, parameters.nominal, parameters.lower)
        upper = np.where(held, parameters.nominal, parameters.upper)
        return cls(lower, upper, parameters.width, held)

    def polish(self, residuals: Callable[[Array], Array], start: Array, *, tol: float = 1e-13) -> Polished:
        """Gauss-Newton steps to the nearest optimum."""
        return gauss_newton(
            residuals, start, self.lower, self.upper, scale=self.scale, tol=tol, max_iterations=MOST_STEPS
        )

    def on_bound(self, x: Array) -> Bools:
        """Parameters with room that stand on one of their bounds, (d,)."""
        return ~self.held & ((x <= self.lower) | (x >= self.upper))
