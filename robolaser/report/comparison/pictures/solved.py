"""How much is solved with how much: the ECDF of running times over runs and targets."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.benchmark.standings import Measure
from robolaser.benchmark.statistics.ecdf import budgets, shares
from robolaser.report.canvas import Picture, picture
from robolaser.report.comparison.field import Field
from robolaser.report.comparison.pictures.ends import beside_names, decades, height_pt, name_ends

PAID = {"evaluations": "evaluations", "seconds": "wall time [s]"}
"""Label of the axis of each measure."""
TITLES = {"evaluations": "Targets reached by evaluations", "seconds": "Targets reached by wall time"}


def solved(field: Field, measure: Measure, title: str) -> Picture | None:
    """Share of targets that runs have reached, over what they paid."""
    arrays = field.arrays
    of_targets, of_runs = {
        "evaluations": (arrays.evaluations, arrays.total_evaluations),
        "seconds": (arrays.seconds, arrays.total_s),
    }[measure]
    spent = budgets(of_targets, of_runs)
    if len(spent) < 2 or spent[0] >= spent[-1]:
        return None
    lines = {
        name: 100 * line
        for name, line in zip(arrays.algorithms, shares(of_targets, spent), strict=True)
        if np.isfinite(line).all()
    }
    names = sorted(lines, key=lambda name: (-lines[name][-1], -lines[name].mean()))
    height = height_pt(names)

    def paint(figure: Figure) -> None:
        ax = beside_names(figure, names)
        ax.set_xscale("log")
        for name in (name for name in field.drawn if name in lines):
            ax.plot(spent, lines[name], color=field.colours[name], drawstyle="steps-post",
                    linewidth=1.8 if name in field.told else 0.9)  # fmt: skip
        ax.set_xlim(spent[0], spent[-1])
        ax.set_ylim(0, 100)
        ax.set_xlabel(PAID[measure])
        ax.set_ylabel("targets reached, over all runs [%]")
        decades(ax.xaxis, 7)
        name_ends(ax, {name: lines[name][-1] / 100 for name in names}, field.colours, height=height)

    first, last = names[0], names[-1]
    return picture(
        title,
        f"Of all targets from {field.target(float(arrays.tolerances[0]))} to"
        f" {field.target(float(arrays.tolerances[-1]))}, half a decade apart, the share that was reached by then,"
        " over all runs and problems. Higher and further left is better. A line that levels off low is of runs"
        " that got stuck.",
        f"In the end {first} has reached {lines[first][-1]:.0f} % of the targets, {last} {lines[last][-1]:.0f} %.",
        paint,
        height_pt=height,
    )
