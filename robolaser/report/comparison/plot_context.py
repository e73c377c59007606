"""What charts and tables of a family of problems share: its algorithms, their order and their colours."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.fixed import QUARTILES
from robolaser.benchmark.objectives import igd_plus
from robolaser.benchmark.problem import CALIBRATION, ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import ResultArrays
from robolaser.benchmark.standings import Standings
from robolaser.benchmark.statistics.intervals import quantiles
from robolaser.benchmark.statistics.profiles import after_evaluations, bands
from robolaser.report.chart import HEIGHT_PX, LINES, MUTED, Channel, colours, records
from robolaser.report.comparison.excess import cost_excess, number, rms_excess, rms_target

LEADING = 5
"""Algorithms that have a colour of their own, by rank."""
PAPERS = "rcga"
"""The paper's algorithm, which has a colour wherever it stands."""
MOMENTS = 160
"""Of convergence traces that are drawn."""
LEGEND_PX = 12
"""By which a chart grows with each algorithm in its legend."""


def target(family: str, tolerance: float) -> str:
    """A target of a family in words."""
    if family == CALIBRATION:
        return f"an RMS within {rms_target(tolerance)} of the best known"
    return f"a cost within {number(tolerance)} of the lowest"


@final
@dataclass(frozen=True, eq=False)
class PlotContext:
    """What charts and tables of a family show.

    Attributes:
        comparison: All families.
        standings: On the problems of this one.
    """

    comparison: BenchmarkResult
    standings: Standings

    @cached_property
    def tally(self) -> ResultArrays:
        """Runs on these problems."""
        return self.comparison.arrays(self.standings.family)

    @cached_property
    def igd_plus(self) -> Mapping[tuple[str, str], Array]:
        """Quartiles of IGD+ by problem and algorithm, where there are several objectives."""
        found = igd_plus(self.comparison).groupby(["problem", "algorithm"]).igd_plus
        return {key: quantiles(values.to_numpy(), QUARTILES) for key, values in found}

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
        """Algorithms, the best first."""
        return tuple(standing.algorithm for standing in self.standings.evaluations.places)

    @cached_property
    def coloured(self) -> Mapping[str, str]:
        """Colours of those with one: the leading ones, the first by wall time, and the paper's."""
        evaluations, seconds = (
            [standing.algorithm for standing in order.places if standing.rank is not None]
            for order in (self.standings.evaluations, self.standings.seconds)
        )
        wanted = [*evaluations[:LEADING], *seconds[:1], *(name for name in self.order if name == PAPERS)]
        return dict(zip(dict.fromkeys(wanted), LINES, strict=False))

    @property
    def height(self) -> float:
        """Of a chart with a line for each algorithm [px]."""
        return HEIGHT_PX + LEGEND_PX * len(self.coloured)

    def back_to_front(self, names: Iterable[str]) -> list[str]:
        """In the order of drawing: those with a colour on top of the others, the best last."""
        return sorted(names, key=lambda name: (name in self.coloured, -self.order.index(name)))

    def rows(self, lines: Mapping[str, Mapping[str, Array]]) -> list[dict[str, object]]:
        """The records of each algorithm's line, by its fields, in the order of drawing."""
        return [row for name in self.back_to_front(lines) for row in records(**lines[name], series=name)]

    def by_algorithm(self, names: Sequence[str], *, shows_legend: bool = True) -> Channel:
        """The colour channel, in the order of the ranking; those without a colour of their own are grey."""
        of = {name: self.coloured.get(name, MUTED) for name in self.order if name in names}
        return colours(of, legend={"orient": "bottom", "columns": 2}, shows_legend=shows_legend)

    def widths(self, names: Sequence[str]) -> Channel:
        """The channel of a line's width: those with a colour are thicker."""
        scale = {
            "type": "ordinal",
            "domain": list(names),
            "range": [2 if name in self.coloured else 1 for name in names],
        }
        return {"field": "series", "type": "nominal", "scale": scale, "legend": None}

    def number(self, problem: str) -> int:
        """Of a problem, from 1, as the page counts them."""
        return 1 + next(i for i, one in enumerate(self.comparison.problems) if one.name == problem)

    def contested(self, name: str) -> ProblemSummary:
        """A problem by its name."""
        return next(problem for problem in self.problems if problem.name == name)

    def target(self, tolerance: float) -> str:
        """A target in words."""
        return target(self.standings.family, tolerance)

    def excess(self, problem: ProblemSummary, tolerance: float) -> str:
        """How far above the best known, for a person."""
        if self.relative(problem):
            return rms_excess(tolerance)
        return cost_excess(tolerance, problem.scale, problem.unit)

    def relative(self, problem: ProblemSummary) -> bool:
        """Is more than next to nothing left at best, so that people would ask how much more an RMS is?"""
        return self.calibrates and problem.scale == abs(problem.best)

    def heights(self, problem: ProblemSummary, tolerance: Array) -> Array:
        """Tolerances as they are drawn: RMS above the best known as a share of it, or cost above the lowest."""
        if self.relative(problem):
            return np.sqrt(1.0 + np.maximum(tolerance, 0.0)) - 1.0
        heights: Array = tolerance * problem.scale
        return heights

    def courses(self, problem: ProblemSummary) -> tuple[Array, Mapping[str, Array]]:
        """Evaluations (g,), and what coloured algorithms have reached by then: one in ten, median, nine in ten."""
        of = {name: [run for run in self.comparison.runs if (run.problem, run.algorithm) == (problem.name, name)]
              for name in self.coloured}  # fmt: skip
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
