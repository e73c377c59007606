"""A least-squares problem as SciPy and other libraries want it: one vector of residuals of the free parameters."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.estimation.least_squares import LeastSquares


@final
@dataclass(frozen=True, eq=False)
class FlatProblem:
    """A problem without fixed parameters, blocks of rows, candidates or losses.

    Its cost is the sum of the squared residuals, whatever the loss: a row e that costs c is scaled to the length √c.
    Parameters are in their own units, and so are derivatives.
    """

    whole: LeastSquares

    @cached_property
    def free(self) -> Bools:
        """Which parameters of the whole problem may change, (d,); f of them do."""
        return np.asarray(self.whole.lower < self.whole.upper)

    @property
    def lower(self) -> Array:
        """Lower bounds, (f,)."""
        return self.whole.lower[self.free]

    @property
    def upper(self) -> Array:
        """Upper bounds, (f,)."""
        return self.whole.upper[self.free]

    @property
    def scale(self) -> Array:
        """A usual change of each parameter, (f,)."""
        return self.whole.scale[self.free]

    def completed(self, free: Array) -> Array:
        """All parameters (d,), those that are fixed included, from the free ones (f,)."""
        x = self.whole.lower.copy()
        x[self.free] = free
        return x

    def residuals(self, free: Array) -> Array:
        """Of all rows, then those that belong to no row, (f,) -> (K,); not finite at poles."""
        x = self.completed(free)[None]
        rows = [part.loss.as_squares(part.residuals(x), part.starts) for _, part in self.whole.blocks]
        flat: Array = np.concatenate([*rows, self.whole.extra_residuals(x)], axis=1)[0]
        return flat

    def jacobian(self, free: Array) -> Array:
        """Derivatives of the residuals by each free parameter, (f,) -> (K, f)."""
        x = self.completed(free)[None]
        rows = [
            part.loss.slopes_as_squares(part.residuals(x), part.jacobian(x), part.starts)
            for _, part in self.whole.blocks
        ]
        J = np.concatenate([*rows, self.whole.extra_jacobian(x)], axis=2)[0]
        slopes: Array = (J[self.free] / self.scale[:, None]).T
        return slopes
