"""SciPy's least squares, from one random start after the other."""

from typing import ClassVar, Literal, final

import numpy as np

from robolaser.algorithms.settings import Setting, number, word
from robolaser.arrays import Array, Bools
from robolaser.comparison.contestants.contestant import Contestant
from robolaser.comparison.question import Question
from robolaser.comparison.watch import Watch

TIGHT = 1e-12
"""SciPy stops at 1e-8 otherwise, in a flat valley before the optimum."""
STEP = np.finfo(np.float64).eps ** 0.5
"""Of the bounds' distance: step of the differences."""


@final
class LeastSquares(Contestant):
    """`scipy.optimize.least_squares` within the bounds; the columns of a Jacobian are one batch of candidates.

    Args:
        name: As asked for.
        method: "trf" or "dogbox".
        tol: SciPy's ftol, xtol and gtol.
    """

    called: ClassVar[str] = "least-squares"
    settings: ClassVar[tuple[Setting, ...]] = (word("method", ("trf", "dogbox")), number("tol", 2.3e-16, 1.0))
    title = "SciPy's least squares from random starts"

    def __init__(self, name: str = called, *, method: Literal["trf", "dogbox"] = "trf", tol: float = TIGHT) -> None:
        self.name, self._method, self._tol = name, method, tol

    def refuses(self, question: Question) -> str | None:
        """What is no sum of squares."""
        return None if question.residuals is not None else "it needs residuals, and the cost is no sum of squares"

    def search(self, watch: Watch, seed: int) -> None:
        """Search until the watch ends it."""
        from scipy.optimize import least_squares  # noqa: PLC0415 - half a second to import

        question, rng = watch.question, np.random.default_rng(seed)
        free = question.upper > question.lower
        lower, upper = question.lower[free], question.upper[free]
        while True:
            start = question.anywhere(rng)[0]
            residuals = _Residuals(watch, start, free)
            if not np.isfinite(residuals(start[free])).all():
                continue
            try:
                least_squares(
                    residuals,
                    start[free],
                    jac=residuals.slopes,
                    bounds=(lower, upper),
                    method=self._method,
                    x_scale=upper - lower,
                    ftol=self._tol,
                    xtol=self._tol,
                    gtol=self._tol,
                )
            except _Pole:
                continue


class _Pole(Exception):
    """The differences of a Jacobian meet a pole."""


@final
class _Residuals:
    """Residuals of the free variables (f,), one candidate at a time; remembers the last ones."""

    def __init__(self, watch: Watch, start: Array, free: Bools) -> None:
        self._watch, self._start, self._free = watch, start, np.flatnonzero(free)
        self._upper, self._width = watch.question.upper, watch.question.upper - watch.question.lower
        self._at, self._were = np.full(len(self._free), np.nan), np.empty(0)

    def __call__(self, z: Array) -> Array:
        if not np.array_equal(z, self._at):
            self._at, self._were = z.copy(), self._watch.residuals(self._whole(z)[None])[0]
        return self._were

    def slopes(self, z: Array) -> Array:
        """Their Jacobian, (r, f): differences forwards, backwards at the upper bound."""
        x, at = self._whole(z), self(z)
        step = STEP * self._width[self._free]
        step = np.where(z + step > self._upper[self._free], -step, step)
        beside = np.tile(x, (len(z), 1))
        beside[np.arange(len(z)), self._free] += step
        taken = beside[np.arange(len(z)), self._free] - z
        slopes: Array = ((self._watch.residuals(beside) - at) / taken[:, None]).T
        if not np.isfinite(slopes).all():
            raise _Pole
        return slopes

    def _whole(self, z: Array) -> Array:
        x = self._start.copy()
        x[self._free] = z
        return x
