"""Who is fastest how often, and who comes close: performance profiles."""

import numpy as np

from robolaser.benchmark.statistics.profiles import performance_profile, performance_ratios
from robolaser.benchmark.statistics.running_time import expected
from robolaser.report.chart import Chart, chart, hover, layer, line, quantity
from robolaser.report.comparison.plot_context import PlotContext

FACTORS = np.geomspace(1.0, 100.0, 120)
"""Times the fastest's evaluations."""


def profiles(context: PlotContext, title: str) -> Chart | None:
    """Share of problems and targets that each algorithm reaches in so many times the evaluations of the fastest."""
    tally = context.tally
    times = expected(tally.evaluations, tally.total_evaluations)
    if len(tally.problems) < 2 or len(tally.algorithms) < 2 or not np.isfinite(performance_ratios(times)).any():
        return None
    found = zip(tally.algorithms, 100 * performance_profile(times, FACTORS), strict=True)
    lines = {name: share for name, share in found if np.isfinite(share).all()}
    names = sorted(lines, key=lambda name: (-lines[name][0], -lines[name][-1]))
    data = context.rows({name: {"factor": FACTORS, "share": share} for name, share in lines.items()})
    return chart(
        title,
        "Of all problems and targets that anybody reached, the share that an algorithm reaches in at most so many times"
        " the expected evaluations of the fastest there (Dolan and Moré 2002). On the left, how often it is fastest.",
        f"{names[0]} is the fastest on {lines[names[0]][0]:.0f} % of problems and targets.",
        [
            layer(
                line(step=True),
                data,
                tooltip=hover("series", factor="times the fastest", share="problems and targets [%]"),
                x=quantity("factor", "times the evaluations of the fastest", log=True, domain=(1, 100)),
                y=quantity("share", "problems and targets reached [%]", domain=(0, 100)),
                color=context.by_algorithm(names),
                strokeWidth=context.widths(names),
            )
        ],
        height=context.height,
    )
