"""SciPy's least squares, from one random start after the other."""

from typing import ClassVar, Literal, final

import numpy as np

from robolaser.algorithms.settings import Setting, number, word
from robolaser.arrays import Array, Bools
from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.problem import Question
from robolaser.benchmark.solvers.solver import Contestant

TIGHT = 1e-12
"""SciPy stops at 1e-8 otherwise, in a flat valley before the optimum."""
STEP = np.finfo(np.float64).eps ** 0.5
"""Of differences by SciPy's rule: of a variable's size, at least of 1."""


@final
class LeastSquares(Contestant):
    """`scipy.optimize.least_squares` within the bounds, as it is: "2-point" differences with its own steps.

    Here the columns of a Jacobian are one batch of candidates, which takes less time and changes no digit. Better
    derivatives would not help: with them descents crawl on for five times as many candidates where nothing is found.

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
        self._lower, self._upper = watch.question.lower[free], watch.question.upper[free]
        self._at, self._were = np.full(len(self._free), np.nan), np.empty(0)

    def __call__(self, z: Array) -> Array:
        if not np.array_equal(z, self._at):
            self._at, self._were = z.copy(), self._watch.residuals(self._whole(z)[None])[0]
        return self._were

    def slopes(self, z: Array) -> Array:
        """Their Jacobian, (r, f): differences away from zero, the other way where a bound is too close."""
        x, at = self._whole(z), self(z)
        down, up = z - self._lower, self._upper - z
        step = STEP * np.where(z >= 0.0, 1.0, -1.0) * np.maximum(1.0, np.abs(z))
        step = np.where((step > up) | (step < -down), -step, step)
        step = np.where((step > up) | (step < -down), np.where(up >= down, up, -down), step)
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
