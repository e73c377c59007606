"""The table of probabilities that the first is better on further problems, or as good as alike."""

from robolaser.benchmark.statistics.signed_rank import ROPE, signed_rank
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.digits import percent
from robolaser.report.document import Cell, Column, Table


def probable_table(context: PlotContext) -> Table | None:
    """The Bayesian signed-rank test of the first against each other; None without another one, or several problems."""
    first = context.order[0]
    rows = {}
    for row in signed_rank(context.tally).itertuples():
        if row.algorithm == first:
            rows[row.other] = (row.better, row.alike, row.worse)
        elif row.other == first:
            rows[row.algorithm] = (row.worse, row.alike, row.better)
    if not rows or len(context.problems) < 2:
        return None
    columns = [
        Column("Against", "name"),
        *(Column(f"{what}") for what in (f"{first} is better", "alike", "it is worse")),
    ]
    cells = [(Cell(name), *(Cell(percent(p), order=p) for p in rows[name])) for name in context.order if name in rows]
    return Table(
        columns,
        cells,
        f"How probable is it that {first} is better on further problems like these?",
        f"Bayesian signed-rank test over problems (Benavoli et al. 2014); alike: superiority within {ROPE} of a half.",
    )
