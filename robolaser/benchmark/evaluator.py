"""Who stands beside a run with a stop-watch: counts evaluations, notes every improvement, ends it when it is time."""

import time
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.convergence import Course
from robolaser.benchmark.problem import Question
from robolaser.errors import CandidateNotANumber, CandidateShape


class Over(BaseException):
    """The budget or the time is used up. No `Exception`: contestants that survive their own errors must not hold it."""


@final
class Watch:
    """The question as one run sees it.

    A candidate outside the bounds is counted and costs infinitely much; so does one at a pole.

    Attributes:
        question: What is asked.
        budget: Candidates that may be evaluated.
        evaluations: Candidates evaluated so far.
        best: Lowest cost so far.
    """

    def __init__(self, question: Question, *, budget: int, time_limit_s: float) -> None:
        self.question = question
        self.budget = budget
        self.evaluations = 0
        self.best = np.inf
        self.out_of_time = False
        self._time_limit_s = time_limit_s
        self._noted: list[tuple[int, float, float]] = []
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
            Over: The budget or the time is used up; what lies beyond the budget does not count.
            CandidateNotANumber: A candidate is not a number.
            CandidateShape: The array is no (c, d).
        """
        x = self._checked(x)
        return self._noting(x, self.question.cost(x))

    def residuals(self, x: Array) -> Array:
        """Residuals of candidates, (c, d) -> (c, r), each counted as one evaluation.

        Raises:
            Over, CandidateNotANumber, CandidateShape: As `cost` does.
        """
        if self.question.residuals is None:
            raise TypeError(f"{self.question.name} is no sum of squares")
        x = self._checked(x)
        residuals = self.question.residuals(x)
        self._noting(x, np.einsum("cr,cr->c", residuals, residuals))
        return residuals

    def saw(self, evaluations: int, cost: float) -> None:
        """Take note of candidates that a contestant evaluated by itself, the best of which cost so much.

        Raises:
            Over: The budget or the time is used up.
        """
        self.evaluations += evaluations
        if self.evaluations <= self.budget and cost < self.best:
            self._note(self.evaluations, cost)
        self._look_at_the_clock()

    def course(self) -> Course:
        """Every improvement so far."""
        evaluations, seconds, costs = zip(*self._noted, strict=True) if self._noted else ((), (), ())
        return Course(np.array(evaluations, np.int64), np.array(seconds, float), np.array(costs, float))

    def _checked(self, x: Array) -> Array:
        x = np.asarray(x, np.float64)
        if x.ndim != 2 or x.shape[1] != self.question.dimension:
            raise CandidateShape(x.shape, self.question.dimension)
        if np.isnan(x).any():
            raise CandidateNotANumber(self.question.variables[int(np.argwhere(np.isnan(x))[0, 1])])
        return x

    def _noting(self, x: Array, costs: Array) -> Array:
        outside = ((x < self.question.lower) | (x > self.question.upper)).any(axis=1)
        costs = np.where(np.isnan(costs) | outside, np.inf, costs)
        allowed = costs[: self.left]
        lowest = np.minimum.accumulate(np.append(self.best, allowed))
        for i in np.flatnonzero(lowest[1:] < lowest[:-1]):
            self._note(self.evaluations + int(i) + 1, float(allowed[i]))
        self.evaluations += len(allowed)
        self._look_at_the_clock()
        return costs

    def _note(self, evaluations: int, cost: float) -> None:
        self.best = cost
        self._noted.append((evaluations, self.seconds(), cost))

    def _look_at_the_clock(self) -> None:
        if self.evaluations >= self.budget:
            self.evaluations = self.budget
            raise Over
        if self.seconds() > self._time_limit_s:
            self.out_of_time = True
            raise Over
