"""How much is solved with how much: the ECDF of running times over runs and targets."""

from typing import Literal

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.standings.table import Measure
from robolaser.benchmark.statistics.profiles import budgets, shares
from robolaser.report.chart import Chart, chart, hover, layer, line, quantity
from robolaser.report.comparison.plot_context import PlotContext

Axis = Literal[Measure, "simplex gradients"]
SPENT = {
    "evaluations": "evaluations", "seconds": "wall time [s]",
    "simplex gradients": "evaluations / (variables + 1)",
}  # fmt: skip
"""Label of the axis of each measure."""
TITLES = {"evaluations": "Targets reached by evaluations", "seconds": "Targets reached by wall time",
          "simplex gradients": "Data profile"}  # fmt: skip


SAME = {
    "seconds": "The same by wall time.",
    "simplex gradients": "The same by simplex gradients of one evaluation more than there are variables, so that"
    " problems of different dimension count alike (Moré and Wild 2009).",
}
"""Captions of the second and the third."""


def solved(context: PlotContext, measure: Axis, title: str) -> Chart | None:
    """Share of targets that runs have reached, over what they spent."""
    tally = context.tally
    of_targets, of_runs = tally.measured("seconds" if measure == "seconds" else "evaluations")
    if measure == "simplex gradients":
        gradient = np.array([context.contested(name).dimension + 1.0 for name in tally.problems])[:, None, None]
        of_targets, of_runs = of_targets / gradient[..., None], of_runs / gradient
    spent = budgets(of_targets, of_runs)
    if len(spent) < 2 or spent[0] >= spent[-1]:
        return None
    lines = {
        name: 100 * reached
        for name, reached in zip(tally.algorithms, shares(of_targets, spent), strict=True)
        if np.isfinite(reached).all()
    }
    names = sorted(lines, key=lambda name: (-lines[name][-1], -lines[name].mean()))
    data = context.rows({name: _steps(spent, share) for name, share in lines.items()})
    first, last = names[0], names[-1]
    return chart(
        title,
        SAME.get(measure)
        or f"Of all targets from {context.target(float(tally.tolerances[0]))} to"
        f" {context.target(float(tally.tolerances[-1]))}, half a decade apart, the share that was reached by then,"
        " over all runs and problems. Higher and further left is better. A line that levels off low means that runs"
        " got stuck.",
        f"In the end {first} has reached {lines[first][-1]:.0f} % of the targets, {last} {lines[last][-1]:.0f} %.",
        [
            layer(
                line(step=True),
                data,
                tooltip=hover("series", spent=SPENT[measure], share="targets reached [%]"),
                x=quantity("spent", SPENT[measure], log=True, domain=(spent[0], spent[-1])),
                y=quantity("share", "targets reached, over all runs [%]", domain=(0, 100)),
                color=context.by_algorithm(names),
                strokeWidth=context.widths(names),
            )
        ],
        height=context.height,
    )


def _steps(spent: Array, share: Array) -> dict[str, Array]:
    """The corners of a line of steps."""
    kept = np.unique([0, *(np.flatnonzero(np.diff(share)) + 1), len(spent) - 1])
    return {"spent": spent[kept], "share": share[kept]}
