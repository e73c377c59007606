"""Each algorithm against each."""

from collections.abc import Mapping

from robolaser.benchmark.standings.answer import chance
from robolaser.benchmark.standings.table import Order, Pair
from robolaser.report.document import Cell, Column, Table

FEW = 8
"""Algorithms up to which a matrix of pairs is shown unfolded."""


def pairwise_matrix(order: Order) -> Table:
    """Algorithms in order, each against each."""
    names = [standing.algorithm for standing in order.places]
    of = {(pair.one, pair.other): pair for pair in order.pairs}
    rows = [
        [Cell(f"{number} {one}"), *(_cell(of, one, other) for other in names)] for number, one in enumerate(names, 1)
    ]
    note = (
        "A12: how often a run of the row's algorithm does better than one of the column's. With a star: significant"
        " after Holm's correction. Blue: the row's is better; orange: the column's."
    )
    columns = [Column("Row beats column"), *(Column(str(number)) for number in range(1, len(names) + 1))]
    return Table(columns, rows if len(names) > 1 else [], "Pairwise comparison", note, FEW, kind="matrix")


def _cell(of: Mapping[tuple[str, str], Pair], one: str, other: str) -> Cell:
    if one == other:
        return Cell("·")
    pair = of.get((one, other)) or of.get((other, one))
    if pair is None or pair.superiority.value is None:
        return Cell(hint="nothing is known of these two")
    value = pair.superiority.value if pair.one == one else 1.0 - pair.superiority.value
    p = "" if pair.p_adjusted is None else f", {chance(pair.p_adjusted)}"
    significant = "significant" if pair.significant else "not significant"
    return Cell(
        f"{value:.2f}{'*' if pair.significant else ''}",
        order=value,
        lean=200 * (value - 0.5),
        hint=f"{one} beats {other} in {100 * value:.0f} % of pairs; {significant}{p}",
    )
