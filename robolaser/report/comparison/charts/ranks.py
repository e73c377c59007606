"""Which algorithms differ significantly: mean ranks with half the critical difference to each side (Nemenyi)."""

from robolaser.benchmark.standings import Ranks
from robolaser.benchmark.standings.phrases import chance
from robolaser.report.chart import INK, Chart, chart, hover, layer, quantity, records
from robolaser.report.comparison.plot_context import PlotContext

ROW_PX, AROUND_PX = 26, 60


def mean_ranks(context: PlotContext, ranks: Ranks, title: str) -> Chart | None:
    """A dot and a bar for each algorithm; bars that do not overlap differ significantly."""
    names, means = ranks.algorithms, ranks.mean_ranks
    if len(names) < 3 or ranks.critical_difference is None:
        return None
    half = ranks.critical_difference / 2
    data = records(
        name=list(names),
        series=list(names),
        mean=list(means),
        low=[mean - half for mean in means],
        high=[mean + half for mean in means],
    )
    x = quantity("mean", "mean rank")
    y = {"field": "name", "type": "nominal", "sort": None, "title": None,
         "axis": {"labelColor": INK, "domain": False}}  # fmt: skip
    colour = context.by_algorithm(list(names), shows_legend=False)
    said = hover("name", mean="mean rank", low="interval from", high="to")
    p = "p unknown" if ranks.p is None else chance(ranks.p)
    return chart(
        title,
        f"Mean rank over {ranks.blocks} blocks, a problem and a seed each; left is better. The bars are one critical"
        f" difference ({ranks.critical_difference:.1f}) long: algorithms whose bars overlap do not differ"
        f" significantly at 5 % (Nemenyi's test; Friedman's over all: {p}).",
        f"Mean ranks from {names[0]}, {means[0]:.1f}, to {names[-1]}, {means[-1]:.1f}.",
        [
            layer({"type": "rule", "strokeWidth": 5, "opacity": 0.35}, data, tooltip=said,
                  x=x | {"field": "low"}, x2={"field": "high"}, y=y, color=colour),
            layer({"type": "point", "size": 90, "opacity": 1}, data, tooltip=said, x=x, y=y, color=colour),
        ],
        height=AROUND_PX + ROW_PX * len(names),
        zoomable=False,
    )  # fmt: skip
