"""What it costs to come closer to the best known."""

import numpy as np

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.standings.table import OnProblem
from robolaser.report.chart import MUTED, Chart, chart, hover, layer, line, quantity, records, rule
from robolaser.report.comparison.charts.anytime import ABOVE
from robolaser.report.comparison.plot_context import PlotContext


def targets(context: PlotContext, problem: ProblemSummary, on: OnProblem, title: str) -> Chart | None:
    """Expected evaluations of every algorithm to each target, the hardest on the right."""
    at = context.heights(problem, context.tally.tolerances)
    lines = {
        result.algorithm: np.array([
            np.nan if reached.evaluations.value is None else reached.evaluations.value for reached in result.targets
        ])
        for result in on.results
    }  # fmt: skip
    lines = {name: ert for name, ert in lines.items() if np.isfinite(ert).any()}
    if not lines:
        return None
    every = np.concatenate([ert[np.isfinite(ert)] for ert in lines.values()])
    low, high = max(every.min() / 1.5, 0.5), every.max() * 1.5
    last = {name: int(np.flatnonzero(np.isfinite(ert))[-1]) for name, ert in lines.items()}
    names = sorted(lines, key=lambda name: -lines[name][last[name]])
    data = context.rows({name: {"target": at, "ert": ert} for name, ert in lines.items()})
    stuck = [name for name in names if last[name] < len(at) - 1]
    ends = records(
        target=[at[last[name]] for name in stuck], ert=[lines[name][last[name]] for name in stuck], series=stuck
    )
    above = ABOVE[context.relative(problem)]
    x = quantity("target", f"target: {above}", log=True, domain=(at[0], at[-1]))
    y = quantity("ert", "expected evaluations (ERT)", log=True, domain=(low, high))
    colour = context.by_algorithm(names)
    said = hover("series", target=above, ert="expected evaluations")
    ranks_by = records(target=float(context.heights(problem, np.array(context.standings.tolerance))))
    cross = {"type": "point", "shape": "cross", "angle": 45, "size": 70, "opacity": 1}
    return chart(
        title,
        "Evaluations needed on average to come this close to the best known, restarting runs that do not get there;"
        " lower is better, harder targets are on the right. A line that ends in a cross stops at the hardest target"
        " that any run reached. Dashed: the target by which algorithms are ranked.",
        f"The hardest target takes {every.min():.0f} evaluations or more.",
        [
            layer(line(), data, tooltip=said, x=x, y=y, color=colour, strokeWidth=context.widths(names)),
            layer(cross, ends, tooltip=said, x=x, y=y, color=colour),
            layer(rule(color=MUTED), ranks_by, x=x),
        ],
        height=context.height,
    )
