"""Each algorithm against each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.standings import Order, Pair
from robolaser.benchmark.standings.phrases import chance


@final
@dataclass(frozen=True)
class PairwiseCell:
    """A cell of the matrix of pairs.

    Attributes:
        share: Of pairs of runs that the row's algorithm wins, 0 to 1 as text; empty where nothing is known.
        lean: From -100, the column's always wins, to 100, the row's does.
        is_significant: Is the difference?
        words: The same as a sentence.
    """

    share: str
    lean: float
    is_significant: bool
    words: str


def pairwise_matrix(order: Order) -> tuple[Sequence[str], Sequence[Sequence[PairwiseCell | None]]]:
    """Algorithms in order, and each against each."""
    names = [standing.algorithm for standing in order.places]
    of = {(pair.one, pair.other): pair for pair in order.pairs}
    return names, [[_cell(of, one, other) for other in names] for one in names]


def _cell(of: Mapping[tuple[str, str], Pair], one: str, other: str) -> PairwiseCell | None:
    if one == other:
        return None
    pair = of.get((one, other)) or of.get((other, one))
    if pair is None or pair.superiority.value is None:
        return PairwiseCell("", 0.0, is_significant=False, words="nothing is known of these two")
    value = pair.superiority.value if pair.one == one else 1.0 - pair.superiority.value
    p = "" if pair.p_adjusted is None else f", {chance(pair.p_adjusted)}"
    significant = "significant" if pair.significant else "not significant"
    return PairwiseCell(
        f"{value:.2f}",
        200 * (value - 0.5),
        pair.significant,
        f"{one} beats {other} in {100 * value:.0f} % of pairs; {significant}{p}",
    )
