"""What it costs to come closer to the best known."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.benchmark.result import ProblemSummary
from robolaser.benchmark.standings import OnProblem
from robolaser.report.canvas import MUTED, Picture, picture
from robolaser.report.comparison.field import Field
from robolaser.report.comparison.pictures.anytime import ABOVE
from robolaser.report.comparison.pictures.ends import beside_names, decades, height_pt, name_ends


def targets(field: Field, problem: ProblemSummary, on: OnProblem, title: str) -> Picture | None:
    """Expected evaluations of every solver to each target, the hardest on the right."""
    at = field.heights(problem, field.arrays.tolerances)
    lines = {
        result.algorithm: np.array([
            np.nan if reached.evaluations.value is None else reached.evaluations.value for reached in result.targets
        ])
        for result in on.results
    }  # fmt: skip
    lines = {name: line for name, line in lines.items() if np.isfinite(line).any()}
    if not lines:
        return None
    bounds = np.concatenate([line[np.isfinite(line)] for line in lines.values()])
    low, high = max(bounds.min() / 1.5, 0.5), bounds.max() * 1.5
    height = height_pt(list(lines))

    def up(evaluations: float) -> float:
        return float(np.log(evaluations / low) / np.log(high / low))

    names = sorted(lines, key=lambda name: -lines[name][np.isfinite(lines[name])][-1])

    def paint(figure: Figure) -> None:
        ax = beside_names(figure, names)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.axvline(float(field.heights(problem, np.array(field.standings.tolerance))), color=MUTED, linewidth=0.8,
                   linestyle=(0, (4, 3)), zorder=0)  # fmt: skip
        for name in (name for name in field.drawn if name in lines):
            told, line = name in field.told, lines[name]
            last = int(np.flatnonzero(np.isfinite(line))[-1])
            colour = field.colours[name]
            ax.plot(at, line, color=colour, linewidth=1.8 if told else 0.9)
            if last < len(at) - 1:
                ax.plot(at[last], line[last], "x", color=colour, ms=5)
                ax.plot([at[last], at[-1]], [line[last]] * 2, color=colour, linewidth=0.6, linestyle=(0, (1, 3)))
        ax.set_xlim(at[0], at[-1])
        ax.set_ylim(low, high)
        ax.set_xlabel(f"target: {ABOVE[field.relative(problem)]}")
        ax.set_ylabel("expected evaluations (ERT)")
        decades(ax.xaxis, 6)
        decades(ax.yaxis, 8)
        ends = {name: up(lines[name][np.isfinite(lines[name])][-1]) for name in names}
        name_ends(ax, ends, field.colours, height=height)

    return picture(
        title,
        "Evaluations that it takes on average to come so close to the best known, runs that do not get there being"
        " begun anew; lower is better, harder targets are on the right. A line that ends in a cross stops at the"
        " hardest target that any run reached. Dashed: the target that ranks.",
        f"The hardest target takes from {bounds.min():.0f} evaluations on.",
        paint,
        height_pt=height,
    )
