"""The evaluator of one run: it counts evaluations, records improvements, and ends the run with its budget."""

import json
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.benchmark.problem import INFEASIBLE, BenchmarkProblem
from robolaser.errors import BenchmarkError

Evaluated = Mapping[str, Array]  # F, G and H of candidates


@final
@dataclass(frozen=True, eq=False)
class ConvergenceTrace:
    """Every improvement of a run, in order (k)."""

    evaluations: Ints  # candidates evaluated up to and including the improvement, (k,)
    seconds: Array  # wall time by then [s], (k,)
    costs: Array  # the improved cost, falling, (k,); of several objectives the non-dominated ones, (k, m)

    @classmethod
    def of(cls, steps: Iterable[Sequence[Any]]) -> Self:
        """The trace of improvements, (evaluations, seconds, cost) each, as in lines of a file."""
        evaluations, seconds, costs = zip(*steps, strict=True) if (steps := list(steps)) else ((), (), ())
        return cls(np.array(evaluations, np.int64), np.array(seconds, float), np.array(costs, float))

    @property
    def final(self) -> float:
        """Lowest cost; infinite if no candidate had a finite one."""
        return float(self.costs[-1]) if len(self.costs) else np.inf

    def first_hits(self, targets: Array) -> tuple[Array, Array]:
        """Evaluations and seconds until costs (t,) were first reached, (t,) each; infinite where they never were."""
        at = np.searchsorted(-self.costs, -targets)  # the first that is no higher, the end if there is none
        return np.append(self.evaluations, np.inf)[at], np.append(self.seconds, np.inf)[at]


def not_dominated(F: Array) -> Bools:
    """Which of candidates' objectives (c, m) are non-dominated, (c,)."""
    import moocore  # noqa: PLC0415 - only several objectives need it

    return np.asarray(moocore.is_nondominated(F))


@final
@dataclass(frozen=True)
class RunLimits:
    """Limits of every run on a problem."""

    budget: int
    time_limit_s: float
    crash_costs_inf: bool = False
    one_by_one: bool = False  # candidates take so long that the time is checked after each
    noisy: bool = False  # the same candidate has another cost each time


class BudgetExhausted(BaseException):
    """The budget or time is used up. Not an `Exception`: solvers that catch their errors must not catch it."""


@final
class BudgetedEvaluator:
    """Evaluates candidates of a problem until the budget or the time of the run is used up.

    A candidate outside the bounds is counted and has infinite cost; so has one at a pole. A search can read the counts,
    but not set them.
    """

    def __init__(self, problem: BenchmarkProblem, limits: RunLimits, spill: str = "") -> None:
        self.problem = problem
        self.spill = spill  # file to which improvements are written at once, in case the process is killed; "": none
        self._limits, self._evaluations = limits, 0
        self.best = np.inf  # lowest cost of a feasible candidate so far, if there is one objective
        self.violation = np.inf  # lowest violation of the constraints so far
        # the candidate of lowest cost so far, (1, d); of several objectives the non-dominated ones
        self.x: Any = np.empty((0, problem.dimension))
        self.out_of_time = False  # whether the run was ended by its time limit
        self._one_by_one = limits.one_by_one or problem.question.elementwise
        self._improvements: list[tuple[int, float, Any]] = []
        self._front = np.empty((0, problem.n_obj))
        self._began = time.perf_counter()

    @property
    def budget(self) -> int:
        """Candidates that may be evaluated; no further one is."""
        return self._limits.budget

    @property
    def evaluations(self) -> int:
        """Candidates evaluated so far."""
        return self._evaluations

    @property
    def left(self) -> int:
        """Candidates that may still be evaluated: none after the end, which a search may have caught."""
        return 0 if self.out_of_time else self.budget - self._evaluations

    def seconds(self) -> float:
        """Wall time so far."""
        return time.perf_counter() - self._began

    def evaluate(self, x: Any) -> Evaluated:
        """Objectives and constraints of candidates (c, d), as `BenchmarkProblem.values`.

        Raises:
            BudgetExhausted: The budget or the time is used up; candidates beyond the budget are not evaluated.
            BenchmarkError: The array is not (c, d), or a candidate is not a number, or not whole.
        """
        x = self._checked(x)
        allowed = x[: self.left]
        size = 1 if self._one_by_one else max(len(allowed), 1)
        parts = []
        for first in range(0, len(allowed), size):
            part = allowed[first : first + size]
            parts.append(self._values(part))
            self._count(part, parts[-1])
        self._end_if_exhausted()
        parts = parts or [self.problem.values(x)]  # of no candidates
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def cost(self, x: Any) -> Array:
        """Costs of candidates, (c, d) -> (c,); infeasible candidates cost more than all feasible ones.

        Raises:
            BudgetExhausted: The budget or the time is used up.
            BenchmarkError: The array is not (c, d), or the problem has several objectives.
        """
        if self.problem.n_obj > 1:
            raise BenchmarkError(
                f"{self.problem.name} has {self.problem.n_obj} objectives: evaluate them with `evaluate(x)`."
            )
        values = self.evaluate(x)
        violation = self.problem.violation(values)
        return np.where(violation > 0.0, INFEASIBLE * (1.0 + violation), values["F"][:, 0])

    def residuals(self, x: Array) -> Array:
        """Residuals of candidates, (c, d) -> (c, r), each counted as one evaluation."""
        if self.problem.residuals is None:
            raise TypeError(f"{self.problem.name} is not a sum of squares")
        x = self._checked(x)
        allowed = x[: self.left]
        residuals = self.problem.residuals(allowed)
        cost = np.where(self._inside(allowed), np.einsum("cr,cr->c", residuals, residuals), np.inf)
        none = np.empty((len(allowed), 0))
        self._count(allowed, {"F": np.where(np.isnan(cost), np.inf, cost)[:, None], "G": none, "H": none})
        self._end_if_exhausted()
        return residuals

    def record(self, evaluations: int, cost: float, x: Array | None = None) -> None:
        """Record a number of candidates evaluated without this evaluator, their lowest cost, and its candidate."""
        if evaluations <= self.left and cost < self.best:
            self._improve(self._evaluations + evaluations, cost, self.x[:0] if x is None else x[None].copy())
        self._spend(evaluations)
        self._end_if_exhausted()

    def trace(self) -> ConvergenceTrace:
        """Every improvement so far."""
        return ConvergenceTrace.of(self._improvements)

    def _checked(self, x: Any) -> Any:
        if self.problem.mixed:
            return np.asarray(x, object).reshape(-1)
        x = np.asarray(x, np.float64)
        if x.ndim != 2 or x.shape[1] != self.problem.dimension:
            raise BenchmarkError(
                f"The solver evaluated an array of shape {x.shape}, expected (candidates, {self.problem.dimension}):"
                " one row for each candidate."
            )
        wrong = np.isnan(x)
        what = "not a number"
        if self.problem.discrete and not wrong.any():
            wrong, what = x != np.round(x), "not a whole number"
        if wrong.any():
            variable = self.problem.variables[int(np.argwhere(wrong)[0, 1])]
            raise BenchmarkError(f"The solver evaluated a candidate whose {variable} is {what}.")
        return x

    def _inside(self, x: Any) -> Any:
        if self.problem.mixed:
            return np.ones(len(x), bool)
        return ((x >= self.problem.lower) & (x <= self.problem.upper)).all(axis=1)

    def _values(self, x: Any) -> Evaluated:
        """Values of candidates; infinite outside the bounds and, with on_error="inf", where a model crashed."""
        inside = self._inside(x)
        try:
            found = self.problem.values(x[inside])
        except Exception:
            if not self._limits.crash_costs_inf:
                raise
            if len(x) > 1:
                each = [self._values(x[i : i + 1]) for i in range(len(x))]
                return {name: np.concatenate([one[name] for one in each]) for name in each[0]}
            found, inside = self.problem.values(x[:0]), np.zeros(1, bool)
        if inside.all():
            return found
        whole = {name: np.full((len(x), values.shape[1]), np.inf) for name, values in found.items()}
        for name, values in found.items():
            whole[name][inside] = values
        return whole

    def _count(self, x: Any, values: Evaluated) -> None:
        violation = self.problem.violation(values)
        self.violation = float(violation.min(initial=self.violation))
        feasible = (violation <= 0.0) & np.isfinite(values["F"]).all(axis=1)
        if self.problem.n_obj > 1:
            self._extend(np.flatnonzero(feasible), x, values["F"])
        else:
            lowest = np.minimum.accumulate(np.append(self.best, np.where(feasible, values["F"][:, 0], np.inf)))
            for i in np.flatnonzero(lowest[1:] < lowest[:-1]):
                self._improve(self._evaluations + int(i) + 1, float(values["F"][i, 0]), x[i : i + 1].copy())
        self._spend(len(x))
        self._end_if_out_of_time()

    def _extend(self, rows: Ints, x: Any, F: Array) -> None:
        """Add non-dominated candidates to the archive."""
        if not len(rows):
            return
        both = np.concatenate([self._front, F[rows]])
        both_x = np.concatenate([self.x, x[rows]]) if len(self.x) else x[rows]
        kept = not_dominated(both)
        known, now = len(self._front), self.seconds()
        new = rows[np.flatnonzero(kept[known:])]
        self._note([(self._evaluations + int(i) + 1, now, F[i].tolist()) for i in new])
        self._front, self.x = both[kept], both_x[kept]

    def _improve(self, evaluations: int, cost: float, x: Any) -> None:
        self.best, self.x = cost, x
        self._note([(evaluations, self.seconds(), cost)])

    def _note(self, improvements: list[tuple[int, float, Any]]) -> None:
        self._improvements += improvements
        self._spill(improvements)

    def _spend(self, evaluations: int) -> None:
        before, self._evaluations = self._evaluations, min(self._evaluations + evaluations, self.budget)
        if before < self._evaluations == self.budget:
            self._spill([()])

    def _spill(self, lines: Sequence[Sequence[Any]]) -> None:
        """Write improvements; an empty one marks the end of the budget."""
        if self.spill:
            with Path(self.spill).open("a") as file:
                file.writelines(json.dumps(one) + "\n" for one in lines)

    def _end_if_exhausted(self) -> None:
        if self._evaluations == self.budget:
            raise BudgetExhausted
        self._end_if_out_of_time()

    def _end_if_out_of_time(self) -> None:
        if self.seconds() > self._limits.time_limit_s:
            self.out_of_time = True
            raise BudgetExhausted
