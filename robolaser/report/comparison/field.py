"""The field of a family of problems: who runs in it, in what order, and in which colours."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import CALIBRATION
from robolaser.benchmark.result import BenchmarkResult, ProblemSummary
from robolaser.benchmark.result_arrays import ResultArrays
from robolaser.benchmark.standings import Standings
from robolaser.benchmark.statistics.anytime import after_evaluations, bands
from robolaser.report.canvas import LINES, MUTED
from robolaser.report.comparison import prices

LEADING = 5
"""Solvers that have a colour of their own, by rank."""
PAPERS = "rcga"
"""The paper's algorithm, which has a colour wherever it stands."""
MOMENTS = 160
"""Of traces that are drawn."""


def target(family: str, tolerance: float) -> str:
    """A target of a family in words."""
    if family == CALIBRATION:
        return f"an RMS within {prices.rms_target(tolerance)} of the best known"
    return f"a cost within {prices.number(tolerance)} of the lowest"


@final
@dataclass(frozen=True, eq=False)
class Field:
    """What pictures and tables of a family show.

    Attributes:
        comparison: All families.
        standings: On the problems of this one.
    """

    comparison: BenchmarkResult
    standings: Standings

    @cached_property
    def arrays(self) -> ResultArrays:
        """Runs on these problems."""
        return self.comparison.arrays(self.standings.family)

    @property
    def problems(self) -> tuple[ProblemSummary, ...]:
        """Of this family."""
        return self.comparison.of(self.standings.family)

    @property
    def calibrates(self) -> bool:
        """Are costs squared errors, which people read as an RMS?"""
        return self.standings.family == CALIBRATION

    @cached_property
    def order(self) -> tuple[str, ...]:
        """Solvers, the best first."""
        return tuple(place.algorithm for place in self.standings.evaluations.places)

    @cached_property
    def told(self) -> Mapping[str, str]:
        """Colour of those told apart at a glance: the leading ones, the first by wall time, and the paper's."""
        evaluations, seconds = (
            [place.algorithm for place in order.places if place.rank is not None]
            for order in (self.standings.evaluations, self.standings.seconds)
        )
        wanted = [*evaluations[:LEADING], *seconds[:1], *(name for name in self.order if name == PAPERS)]
        return dict(zip(dict.fromkeys(wanted), LINES, strict=False))

    @cached_property
    def colours(self) -> Mapping[str, str]:
        """Of every solver."""
        return {name: self.told.get(name, MUTED) for name in self.order}

    @cached_property
    def drawn(self) -> tuple[str, ...]:
        """Solvers in the order of drawing: those told apart on top of the others, the best last."""
        return tuple(sorted(self.order, key=lambda name: (name in self.told, -self.order.index(name))))

    def number(self, problem: str) -> int:
        """Of a problem, from 1, as the page counts them."""
        return 1 + next(i for i, one in enumerate(self.comparison.problems) if one.name == problem)

    def problem_named(self, name: str) -> ProblemSummary:
        """A problem by its name."""
        return next(problem for problem in self.problems if problem.name == name)

    def target(self, tolerance: float) -> str:
        """A target in words."""
        return target(self.standings.family, tolerance)

    def excess(self, problem: ProblemSummary, tolerance: float) -> str:
        """How far above the best known, for a person."""
        if self.relative(problem):
            return prices.rms_excess(tolerance)
        return prices.cost_excess(tolerance, problem.scale, problem.unit)

    def relative(self, problem: ProblemSummary) -> bool:
        """Is more than next to nothing left at best, so that people would ask how much more an RMS is?"""
        return self.calibrates and problem.scale == abs(problem.best)

    def heights(self, problem: ProblemSummary, tolerance: Array) -> Array:
        """Tolerances as they are drawn: RMS above the best known as a share of it, or cost above the lowest."""
        if self.relative(problem):
            return np.sqrt(1.0 + np.maximum(tolerance, 0.0)) - 1.0
        heights: Array = tolerance * problem.scale
        return heights

    def traces(self, problem: ProblemSummary) -> tuple[Array, Mapping[str, Array]]:
        """Evaluations (g,), and what solvers told apart have reached by then: one in ten, median, nine in ten."""
        of = {name: [run for run in self.comparison.runs if (run.problem, run.algorithm) == (problem.name, name)]
              for name in self.told}  # fmt: skip
        first = [run.trace.evaluations[0] for runs in of.values() for run in runs if len(run.trace.evaluations)]
        if not first or not np.isfinite(problem.best):
            return np.empty(0), {}
        at = np.geomspace(max(1, min(first)), max(self.comparison.budget, 2 * min(first)), MOMENTS)
        return at, {
            name: self.heights(
                problem, bands(after_evaluations([run.trace for run in runs], at), problem.best, problem.scale)
            )
            for name, runs in of.items()
            if runs
        }
