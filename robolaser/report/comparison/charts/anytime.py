"""How good an algorithm is whenever it is stopped."""

import numpy as np

from robolaser.benchmark.problem import ProblemSummary
from robolaser.report.chart import Chart, chart, hover, layer, line, quantity, records
from robolaser.report.comparison.plot_context import PlotContext

LOWEST, HIGHEST = 1e-7, 1e4
"""Excess that is drawn: of an RMS as a share of the best known, of other costs as it is."""
ABOVE = {True: "relative RMS above the best known", False: "cost above the lowest"}
"""Label of the axis, where the excess is relative and where it is not."""


def anytime(context: PlotContext, problem: ProblemSummary, title: str) -> Chart | None:
    """Median convergence of the leading algorithms, with what the best and the worst tenth of runs do."""
    spent, traces = context.courses(problem)
    lines = {name: trace for name, trace in traces.items() if np.isfinite(trace[1]).any()}
    if not lines:
        return None
    names = sorted(lines, key=lambda name: tuple(-lines[name][1, ::-1]))
    low = max(LOWEST, min(float(trace[1, -1]) for trace in lines.values()) / 3)
    high = max(float(trace[1][np.isfinite(trace[1])][0]) for trace in lines.values())
    high = max(min(HIGHEST, 2 * high), 10 * low)
    data = []
    for name in context.back_to_front(lines):
        drawn = np.clip(lines[name], low, 10 * high)
        kept = np.unique(
            [0, *(np.flatnonzero((np.diff(drawn) != 0).any(axis=0)) + 1), len(spent) - 1]
        )  # corners of steps
        better, median, worse = drawn[:, kept]
        data += records(spent=spent[kept], better=better, median=median, worse=worse, series=name)
    above = ABOVE[context.relative(problem)]
    x = quantity("spent", "evaluations", log=True, domain=(spent[0], spent[-1]))
    y = quantity("median", above, log=True, domain=(low, high))
    colour = context.by_algorithm(list(reversed(names)))
    band = {"type": "area", "interpolate": "step-after", "opacity": 0.13, "clip": True}
    said = hover("series", spent="evaluations", median="median", better="best tenth", worse="worst tenth")
    return chart(
        title,
        "The best so far, whenever a run is stopped: the median run, and shaded from the best tenth of the runs to the"
        " worst. The lower edge is the best known, or as good as that. Only algorithms that have a colour are drawn.",
        f"In the end {names[-1]} is lowest of those drawn.",
        [
            layer(band, data, x=x, y=y | {"field": "better"}, y2={"field": "worse"}, color=colour),
            layer(line(step=True, strokeWidth=2), data, tooltip=said, x=x, y=y, color=colour),
        ],
        height=context.height,
    )
