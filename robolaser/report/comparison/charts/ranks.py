"""Which algorithms differ significantly: mean ranks, with a letter for each set of algorithms that do not."""

from string import ascii_letters

from robolaser.benchmark.standings.table import Order
from robolaser.report.chart import Chart, chart, hover, layer, named_rows, quantity, records
from robolaser.report.comparison.plot_context import PlotContext

ROW_PX, AROUND_PX = 26, 60


def mean_ranks(context: PlotContext, order: Order, title: str) -> Chart | None:
    """A dot and letters for each algorithm; two that share no letter differ significantly. Piepho 2004."""
    names = [place.algorithm for place in order.ranked]
    means = [place.mean_rank or 0.0 for place in order.ranked]
    if len(names) < 3 or len(order.groups) > len(ascii_letters):
        return None
    data = records(
        name=names,
        series=names,
        mean=means,
        letters=[
            "".join(letter for letter, group in zip(ascii_letters, order.groups, strict=False) if name in group)
            for name in names
        ],
    )
    x = quantity("mean", "mean rank")
    y = named_rows("name")
    colour = context.by_algorithm(names, shows_legend=False)
    said = hover("name", "letters", mean="mean rank")
    letter = {"type": "text", "align": "left", "dx": 10}
    return chart(
        title,
        f"Mean rank over {order.blocks} blocks, a problem and a seed each; left is better. Two algorithms that share a"
        " letter do not differ significantly, two that share none do, by the same tests as the sentences and the table"
        " of pairs.",
        f"Mean ranks from {names[0]}, {means[0]:.1f}, to {names[-1]}, {means[-1]:.1f}.",
        [
            layer({"type": "point", "size": 90, "opacity": 1}, data, tooltip=said, x=x, y=y, color=colour),
            layer(letter, data, x=x, y=y, text={"field": "letters"}),
        ],
        height=AROUND_PX + ROW_PX * len(names),
        zoomable=False,
    )  # fmt: skip
