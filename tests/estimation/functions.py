"""Functions as least-squares problems, for tests of the solver."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robolaser.estimation.robust_loss import SQUARE, Loss


@dataclass(frozen=True, eq=False)
class FunctionProblem:
    """Minimise the squares or losses of a function, candidates (c, d) -> (c, K), with `axes` numbers a row."""

    function: object
    start: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    loss: Loss = SQUARE
    axes: int = 1

    @cached_property
    def scale(self):
        width = np.where(self.upper > self.lower, self.upper - self.lower, 1.0)
        return np.where(np.isfinite(width), width, np.maximum(np.abs(self.start), 1.0))

    @cached_property
    def _numbers(self):
        return self.residuals(self.start[None]).shape[1]

    @property
    def rows(self):
        return self._numbers // self.axes

    @property
    def starts(self):
        return np.arange(0, self._numbers, self.axes)

    @property
    def row_of_number(self):
        return np.arange(self._numbers) // self.axes

    @property
    def batches(self):
        return ((np.arange(self.rows), self),)

    def extra_residuals(self, x):
        return np.zeros((len(x), 0))

    def extra_jacobian(self, x):
        return np.zeros((*x.shape, 0))

    def residuals(self, x):
        return self.function(x)

    def jacobian(self, x):
        moving = np.flatnonzero(self.upper > self.lower)
        step = np.minimum(1e-5 * self.scale, (self.upper - self.lower) / 4)
        J = np.zeros((*x.shape, self._numbers))
        for i in moving:
            ahead, behind = (
                np.clip(x + way * step[i] * np.eye(len(step))[i], self.lower, self.upper) for way in (1, -1)
            )
            J[:, i] = (self.function(ahead) - self.function(behind)) / (ahead - behind)[:, [i]]
        return J * self.scale[:, None]
