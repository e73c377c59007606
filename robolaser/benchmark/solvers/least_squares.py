"""SciPy's least squares, from one random start after another."""

from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import Solver

TIGHT = 1e-12
"""SciPy's default of 1e-8 stops in a flat valley before the optimum."""
STEP = np.finfo(np.float64).eps ** 0.5
"""SciPy's step of differences, relative to the variable's size, but at least to 1."""


@final
class ScipyLeastSquares(Solver):
    """`scipy.optimize.least_squares` within the bounds, with its "2-point" differences and their steps.

    The columns of a Jacobian are one batch of candidates here, which takes less time and gives the same digits. More
    exact derivatives would not help: descents that find nothing then go on for five times as many candidates.
    """

    name = "least-squares"
    title = "SciPy's least squares from random starts"

    def __init__(self, *, method: Literal["trf", "dogbox"] = "trf", tol: float = TIGHT) -> None:
        self._method, self._tol = method, tol

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """It does not apply to costs that are not a sum of squares."""
        return None if problem.residuals is not None else "it needs residuals, and the cost is not a sum of squares"

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run."""
        from scipy.optimize import least_squares  # noqa: PLC0415 - half a second to import

        problem, rng = evaluator.problem, np.random.default_rng(seed)
        free = problem.upper > problem.lower
        lower, upper = problem.lower[free], problem.upper[free]
        while True:
            start = problem.sample_uniform(rng)[0]
            residuals = _Residuals(evaluator, start, free)
            if not np.isfinite(residuals(start[free])).all():
                continue
            try:
                least_squares(
                    residuals,
                    start[free],
                    jac=residuals.jacobian,
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
    """A column of a Jacobian is at a pole."""


@final
class _Residuals:
    """Residuals as a function of the free variables (f,), one candidate at a time; it remembers the last one."""

    def __init__(self, evaluator: BudgetedEvaluator, start: Array, free: Bools) -> None:
        self._evaluator, self._start, self._free = evaluator, start, np.flatnonzero(free)
        self._lower, self._upper = evaluator.problem.lower[free], evaluator.problem.upper[free]
        self._last, self._last_residuals = np.full(len(self._free), np.nan), np.empty(0)

    def __call__(self, z: Array) -> Array:
        if not np.array_equal(z, self._last):
            self._last, self._last_residuals = z.copy(), self._evaluator.residuals(self._whole(z)[None])[0]
        return self._last_residuals

    def jacobian(self, z: Array) -> Array:
        """Jacobian, (r, f): differences away from zero, or the other way where a bound is too close."""
        x, at = self._whole(z), self(z)
        down, up = z - self._lower, self._upper - z
        step = STEP * np.where(z >= 0.0, 1.0, -1.0) * np.maximum(1.0, np.abs(z))
        step = np.where((step > up) | (step < -down), -step, step)
        step = np.where((step > up) | (step < -down), np.where(up >= down, up, -down), step)
        beside = np.tile(x, (len(z), 1))
        beside[np.arange(len(z)), self._free] += step
        taken = beside[np.arange(len(z)), self._free] - z
        jacobian: Array = ((self._evaluator.residuals(beside) - at) / taken[:, None]).T
        if not np.isfinite(jacobian).all():
            raise _Pole
        return jacobian

    def _whole(self, z: Array) -> Array:
        x = self._start.copy()
        x[self._free] = z
        return x
