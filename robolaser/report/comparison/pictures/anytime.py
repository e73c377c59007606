"""How good a solver is whenever it is stopped."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.benchmark.result import ProblemSummary
from robolaser.report.canvas import Picture, picture
from robolaser.report.comparison.field import Field
from robolaser.report.comparison.pictures.ends import beside_names, decades, height_pt, name_ends

LOWEST, HIGHEST = 1e-7, 1e4
"""Excess that is drawn: of an RMS as a share of the best known, of other costs as it is."""
ABOVE = {True: "RMS above the best known, as a share of it", False: "cost above the lowest"}
"""Label of the axis, where the excess is relative and where it is not."""


def anytime(field: Field, problem: ProblemSummary, title: str) -> Picture | None:
    """Median trace of the leading solvers, with what the best and the worst tenth of runs do."""
    spent, traces = field.traces(problem)
    lines = {name: line for name, line in traces.items() if np.isfinite(line[1]).any()}
    if not lines:
        return None
    names = sorted(lines, key=lambda name: tuple(-lines[name][1, ::-1]))
    low = max(LOWEST, min(float(line[1, -1]) for line in lines.values()) / 3)
    high = max(float(line[1][np.isfinite(line[1])][0]) for line in lines.values())
    high = max(min(HIGHEST, 2 * high), 10 * low)
    height = height_pt(names)

    def paint(figure: Figure) -> None:
        ax = beside_names(figure, names)
        ax.set_xscale("log")
        ax.set_yscale("log")
        for name in (name for name in field.drawn if name in lines):
            better, median, worse = np.clip(lines[name], low, 10 * high)
            colour = field.colours[name]
            ax.fill_between(spent, better, worse, color=colour, alpha=0.13, linewidth=0, step="post")
            ax.plot(spent, median, color=colour, drawstyle="steps-post", linewidth=1.8)
        ax.set_xlim(spent[0], spent[-1])
        ax.set_ylim(low, high)
        ax.set_xlabel("evaluations")
        ax.set_ylabel(ABOVE[field.relative(problem)])
        decades(ax.xaxis, 7)
        decades(ax.yaxis, 10)
        ends = {
            name: float(np.log(np.clip(lines[name][1, -1], low, high) / low) / np.log(high / low)) for name in names
        }
        name_ends(ax, ends, field.colours, height=height)

    return picture(
        title,
        "The best so far, whenever a run is stopped: the median run, and shaded from the best tenth of the runs to the"
        " worst. The lower edge is the best known, or as good as that. Only solvers that have a colour are drawn.",
        f"In the end {names[-1]} is lowest of those drawn.",
        paint,
        height_pt=height,
    )
