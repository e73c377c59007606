"""The chart of a comparison: the share of targets that runs have reached, over the evaluations that they spent."""

from collections.abc import Mapping, Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.table import Standings
from robolaser.benchmark.statistics.running_time import budgets, shares
from robolaser.report.chart import HEIGHT_PX, LINES, MUTED, Chart, chart, colours, hover, layer, line, quantity, records
from robolaser.report.comparison.words import number

LEADING = 6
"""Algorithms that have a colour of their own, by rank."""


def numbers(standings: Standings) -> Mapping[str, int]:
    """Numbers of the colours of the algorithms that have one."""
    return {place.algorithm: i for i, place in enumerate(standings.order.places[:LEADING])}


def solved(comparison: BenchmarkResult, standings: Standings, title: str) -> Chart | None:
    """Share of targets that runs have reached, over the evaluations that they spent."""
    arrays = comparison.arrays(standings.family)
    spent = budgets(arrays.evaluations, arrays.total_evaluations)
    if len(spent) < 2 or spent[0] >= spent[-1]:
        return None
    reached = dict(zip(arrays.algorithms, 100 * shares(arrays.evaluations, spent), strict=True))
    drawn = {name: _steps(spent, share) for name, share in reached.items() if np.isfinite(share).all()}
    last = max(drawn, key=lambda name: reached[name][-1])
    order, coloured = [place.algorithm for place in standings.order.places], numbers(standings)
    of = {name: LINES[coloured[name]] if name in coloured else MUTED for name in order if name in drawn}
    return chart(
        title,
        f"Share of all {len(arrays.tolerances)} targets from {number(arrays.tolerances[0])} to"
        f" {number(arrays.tolerances[-1])} above the lowest known cost (relative to J), over all runs and problems,"
        " reached by then. Higher and further left is better. A line that levels off low means that runs got stuck.",
        f"In the end {last} has reached {reached[last][-1]:.0f} % of the targets.",
        [
            layer(
                line(step=True),
                [row for name in reversed(of) for row in records(**drawn[name], series=name)],  # the best drawn last
                tooltip=hover("series", spent="evaluations", share="targets reached [%]"),
                x=quantity("spent", "evaluations", log=True, domain=(spent[0], spent[-1])),
                y=quantity("share", "targets reached, over all runs [%]", domain=(0, 100)),
                color=colours(of, legend={"orient": "bottom", "columns": 2}),
            )
        ],
        height=HEIGHT_PX + 12 * min(len(order), LEADING),
    )


def _steps(spent: Array, share: Array) -> dict[str, Array]:
    """The corners of a line of steps."""
    kept: Sequence[int] = np.unique([0, *(np.flatnonzero(np.diff(share)) + 1), len(spent) - 1]).tolist()
    return {"spent": spent[kept], "share": share[kept]}
