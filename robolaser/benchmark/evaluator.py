"""A problem as one run sees it: evaluations are counted, improvements recorded, and the run ends with its budget."""

import time
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.benchmark.problem import INFEASIBLE, BenchmarkProblem
from robolaser.errors import BenchmarkError


@final
@dataclass(frozen=True, eq=False)
class ConvergenceTrace:
    """Every improvement of a run, in order (k)."""

    evaluations: Ints  # candidates evaluated up to and including the improvement, (k,)
    seconds: Array  # wall time by then [s], (k,)
    costs: Array  # the improved cost, falling, (k,)

    @property
    def final(self) -> float:
        """Lowest cost; infinite if no candidate had a finite one."""
        return float(self.costs[-1]) if len(self.costs) else np.inf

    def first_hits(self, targets: Array) -> tuple[Array, Array]:
        """Evaluations and seconds until costs (t,) were first reached, (t,) each; infinite where they never were."""
        if not len(self.costs):
            return np.full(len(targets), np.inf), np.full(len(targets), np.inf)
        at = np.searchsorted(-self.costs, -targets)  # the first that is no higher
        reached = at < len(self.costs)
        at = np.where(reached, at, 0)
        return np.where(reached, self.evaluations[at], np.inf), np.where(reached, self.seconds[at], np.inf)

    def best_after(self, evaluations: Array) -> Array:
        """Lowest cost after that many evaluations (e,) -> (e,); infinite before the first."""
        return np.append(np.inf, self.costs)[np.searchsorted(self.evaluations, evaluations, side="right")]


class BudgetExhausted(BaseException):
    """The budget or time is used up. Not an `Exception`: solvers that survive their own errors must not catch it."""


@final
class BudgetedEvaluator:
    """Evaluates candidates of a problem until the budget or the time of the run is used up.

    A candidate outside the bounds is counted and has infinite cost; so has one at a pole.

    Attributes:
        problem: The problem.
        budget: Candidates that may be evaluated.
        evaluations: Candidates evaluated so far.
        best: Lowest cost of a feasible candidate so far; of several objectives, what the front so far misses.
        x: The candidate of lowest cost so far, (1, d); none, (0, d), before any, or if the solver does not say.
        front: What is not dominated so far, if the problem has several objectives.
        violation: Lowest violation of the constraints so far; infinite before any candidate.
        out_of_time: Whether the run was ended by its time limit.
    """

    def __init__(self, problem: BenchmarkProblem, *, budget: int, time_limit_s: float) -> None:
        self.problem = problem
        self.budget = budget
        self.evaluations = 0
        self.best = self.violation = np.inf
        self.front = problem.front
        self.x: Array = np.empty((0, problem.dimension))
        self.out_of_time = False
        self._time_limit_s = time_limit_s
        self._improvements: list[tuple[int, float, float]] = []
        self._began = time.perf_counter()

    @property
    def left(self) -> int:
        """Candidates that may still be evaluated."""
        return max(self.budget - self.evaluations, 0)

    def seconds(self) -> float:
        """Wall time so far."""
        return time.perf_counter() - self._began

    def cost(self, x: Array) -> Array:
        """Costs of candidates, (c, d) -> (c,).

        Raises:
            BudgetExhausted: The budget or the time is used up; candidates beyond the budget do not count.
            BenchmarkError: The array is not (c, d), or a candidate is not a number.
        """
        if self.front is not None:
            raise BenchmarkError(
                f"{self.problem.name} has {len(self.front.ideal)} objectives: evaluate them with `objectives(x)`."
            )
        x = self._checked(x)
        return self._recorded(x, self.problem.cost(x))

    def objectives(self, x: Array) -> Array:
        """Objectives of candidates, (c, d) -> (c, m); the front counts as improved by all of them at once."""
        if self.front is None:
            return self.cost(x)[:, None]
        x = self._checked(x)
        values = self._allowed(x, self.problem.cost(x))
        counted = values[: self.left]
        self.violation = self._lowest_violation(counted[:, 0])
        feasible = (counted < INFEASIBLE).all(axis=1)
        self.front = self.front.extended(counted[feasible], x[: len(counted)][feasible])
        self.record(min(len(x), self.left), self.front.missing if len(self.front.points) else np.inf)
        return values

    def residuals(self, x: Array) -> Array:
        """Residuals of candidates, (c, d) -> (c, r), each counted as one evaluation."""
        if self.problem.residuals is None:
            raise TypeError(f"{self.problem.name} is not a sum of squares")
        x = self._checked(x)
        residuals = self.problem.residuals(x)
        self._recorded(x, np.einsum("cr,cr->c", residuals, residuals))
        return residuals

    def record(self, evaluations: int, cost: float, x: Array | None = None) -> None:
        """Count candidates that a solver evaluated without this evaluator, the lowest cost of them, and whose it is."""
        self.evaluations += evaluations
        if self.evaluations <= self.budget and cost < self.best:
            self._improve(self.evaluations, cost)
            self.x = self.x[:0] if x is None else x[None].copy()
        self._end_if_exhausted()

    def trace(self) -> ConvergenceTrace:
        """Every improvement so far."""
        evaluations, seconds, costs = zip(*self._improvements, strict=True) if self._improvements else ((), (), ())
        return ConvergenceTrace(np.array(evaluations, np.int64), np.array(seconds, float), np.array(costs, float))

    def _checked(self, x: Array) -> Array:
        x = np.asarray(x, np.float64)
        if x.ndim != 2 or x.shape[1] != self.problem.dimension:
            raise BenchmarkError(
                f"The solver evaluated an array of shape {x.shape}, expected (candidates, {self.problem.dimension}):"
                " one row for each candidate."
            )
        if np.isnan(x).any():
            variable = self.problem.variables[int(np.argwhere(np.isnan(x))[0, 1])]
            raise BenchmarkError(f"The solver evaluated a candidate whose {variable} is not a number.")
        return x

    def _recorded(self, x: Array, costs: Array) -> Array:
        costs = self._allowed(x, costs)
        allowed = costs[: self.left]
        if self.problem.constraints:
            self.violation = self._lowest_violation(allowed)
            allowed = np.where(allowed >= INFEASIBLE, np.inf, allowed)
        lowest = np.minimum.accumulate(np.append(self.best, allowed))
        for i in np.flatnonzero(lowest[1:] < lowest[:-1]):
            self._improve(self.evaluations + int(i) + 1, float(allowed[i]))
            self.x = x[i : i + 1].copy()
        self.evaluations += len(allowed)
        self._end_if_exhausted()
        return costs

    def _allowed(self, x: Array, costs: Array) -> Array:
        """Costs of candidates, infinite outside the bounds and where they are not numbers."""
        outside = ((x < self.problem.lower) | (x > self.problem.upper)).any(axis=1)
        costs = np.where(np.isnan(costs), np.inf, costs)
        costs[outside] = np.inf
        return costs

    def _lowest_violation(self, costs: Array) -> float:
        return float(np.maximum(costs / INFEASIBLE - 1.0, 0.0).min(initial=self.violation))

    def _improve(self, evaluations: int, cost: float) -> None:
        self.best = cost
        self._improvements.append((evaluations, self.seconds(), cost))

    def _end_if_exhausted(self) -> None:
        if self.evaluations >= self.budget:
            self.evaluations = self.budget
            raise BudgetExhausted
        if self.seconds() > self._time_limit_s:
            self.out_of_time = True
            raise BudgetExhausted
