"""The charts of a comparison: targets reached and, of two objectives, what half of the runs attained."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.measures import attainment
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.table import Standings
from robolaser.benchmark.statistics.running_time import budgets, shares
from robolaser.report.chart import (
    HEIGHT_PX,
    LINES,
    MUTED,
    Channel,
    Chart,
    chart,
    colours,
    hover,
    layer,
    line,
    quantity,
    records,
)
from robolaser.report.comparison.words import number

LEADING = 6
"""Algorithms that have a colour of their own, by rank."""


@final
@dataclass(frozen=True, eq=False)
class AlgorithmLines:
    """The algorithms of a family and their colours."""

    comparison: BenchmarkResult
    standings: Standings

    @cached_property
    def order(self) -> tuple[str, ...]:
        """Algorithms, the best first."""
        return tuple(place.algorithm for place in self.standings.order.places)

    @cached_property
    def numbers(self) -> Mapping[str, int]:
        """Numbers of the colours of those with one."""
        return {name: i for i, name in enumerate(self.order[:LEADING])}

    def colour(self, names: Iterable[str]) -> Channel:
        """The colour channel, in the order of the ranking; those without a colour of their own are grey."""
        drawn = set(names)
        of = {
            name: LINES[self.numbers[name]] if name in self.numbers else MUTED for name in self.order if name in drawn
        }
        return colours(of, legend={"orient": "bottom", "columns": 2})

    def rows(self, lines: Mapping[str, Mapping[str, Array]]) -> list[dict[str, object]]:
        """The records of each algorithm's line, by its fields, the best drawn last."""
        return [row for name in reversed(self.order) if name in lines for row in records(**lines[name], series=name)]

    @property
    def height(self) -> float:
        """Of a chart [px]."""
        return HEIGHT_PX + 12 * min(len(self.order), LEADING)


def solved(lines: AlgorithmLines, title: str) -> Chart | None:
    """Share of targets that runs have reached, over the evaluations that they spent."""
    arrays = lines.comparison.arrays(lines.standings.family)
    spent = budgets(arrays.evaluations, arrays.total_evaluations)
    if len(spent) < 2 or spent[0] >= spent[-1]:
        return None
    reached = dict(zip(arrays.algorithms, 100 * shares(arrays.evaluations, spent), strict=True))
    drawn = {name: _steps(spent, share) for name, share in reached.items() if np.isfinite(share).all()}
    last = max(drawn, key=lambda name: reached[name][-1])
    return chart(
        title,
        f"Share of all {len(arrays.tolerances)} targets from {number(arrays.tolerances[0])} to"
        f" {number(arrays.tolerances[-1])} above the lowest known cost (relative to J), over all runs and problems,"
        " reached by then. Higher and further left is better. A line that levels off low means that runs got stuck.",
        f"In the end {last} has reached {reached[last][-1]:.0f} % of the targets.",
        [
            layer(
                line(step=True),
                lines.rows(drawn),
                tooltip=hover("series", spent="evaluations", share="targets reached [%]"),
                x=quantity("spent", "evaluations", log=True, domain=(spent[0], spent[-1])),
                y=quantity("share", "targets reached, over all runs [%]", domain=(0, 100)),
                color=lines.colour(drawn),
            )
        ],
        height=lines.height,
    )


def attained(lines: AlgorithmLines, problem: ProblemSummary, title: str) -> Chart | None:
    """Median attainment surfaces of the leading algorithms, of two objectives."""
    if problem.objectives != 2:
        return None
    of = {name: [run for run in lines.comparison.made if run.key[:2] == (problem.name, name)] for name in lines.numbers}
    surfaces = {name: attainment(runs) for name, runs in of.items() if runs}
    drawn = {name: one[one[:, 0].argsort()] for name, one in surfaces.items() if len(one)}
    if not drawn:
        return None
    return chart(
        title,
        "What half of the runs have attained or dominated in the end; nearer to the lower left corner is better"
        " (Grunert da Fonseca, Fonseca and Hall 2001).",
        f"The surfaces of {', '.join(drawn)}.",
        [
            layer(
                line(step=True),
                lines.rows({name: {"first": one[:, 0], "second": one[:, 1]} for name, one in drawn.items()}),
                tooltip=hover("series", first="first objective", second="second objective"),
                x=quantity("first", "first objective"),
                y=quantity("second", "second objective"),
                color=lines.colour(drawn),
            )
        ],
        height=lines.height,
    )


def _steps(spent: Array, share: Array) -> dict[str, Array]:
    """The corners of a line of steps."""
    kept: Sequence[int] = np.unique([0, *(np.flatnonzero(np.diff(share)) + 1), len(spent) - 1]).tolist()
    return {"spent": spent[kept], "share": share[kept]}
