"""What half of the runs attained, where there are two objectives."""

from robolaser.benchmark.objectives import attainment
from robolaser.benchmark.problem import ProblemSummary
from robolaser.report.chart import Chart, chart, hover, layer, line, quantity
from robolaser.report.comparison.plot_context import PlotContext


def attained(context: PlotContext, problem: ProblemSummary, title: str) -> Chart | None:
    """Median attainment surfaces of the leading algorithms."""
    surfaces = {name: attainment(context.comparison, problem.name, name, (0.5,)) for name in context.coloured}
    lines = {name: surface[surface[:, 0].argsort()] for name, surface in surfaces.items() if surface.shape[1:] == (3,)}
    if not any(len(surface) for surface in lines.values()):
        return None
    names = [name for name in context.order if name in lines]
    data = context.rows({name: {"first": one[:, 0], "second": one[:, 1]} for name, one in lines.items()})
    return chart(
        title,
        "What half of the runs have attained or dominated in the end; nearer to the lower left corner is better"
        " (Grunert da Fonseca, Fonseca and Hall 2001).",
        f"The surfaces of {', '.join(names)}.",
        [
            layer(
                line(step=True),
                data,
                tooltip=hover("series", first="first objective", second="second objective"),
                x=quantity("first", "first objective"),
                y=quantity("second", "second objective"),
                color=context.by_algorithm(names),
            )
        ],
        height=context.height,
    )
