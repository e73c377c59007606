"""Each solver against each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.standings import Order, Pair
from robolaser.benchmark.standings.phrases import chance


@final
@dataclass(frozen=True)
class Duel:
    """A cell of the matrix of pairs.

    Attributes:
        share: Of pairs of runs that the row's solver wins, 0 to 1 as text; empty where nothing is known.
        lean: From -100, the column's always wins, to 100, the row's does.
        told: Can the two be told apart?
        words: The same as a sentence.
    """

    share: str
    lean: float
    told: bool
    words: str


def duels(order: Order) -> tuple[Sequence[str], Sequence[Sequence[Duel | None]]]:
    """Solvers in order, and each against each."""
    names = [place.algorithm for place in order.places]
    of = {(pair.one, pair.other): pair for pair in order.pairs}
    return names, [[_duel(of, one, other) for other in names] for one in names]


def _duel(of: Mapping[tuple[str, str], Pair], one: str, other: str) -> Duel | None:
    if one == other:
        return None
    pair = of.get((one, other)) or of.get((other, one))
    if pair is None or pair.superiority.value is None:
        return Duel("", 0.0, told=False, words="nothing is known of these two")
    value = pair.superiority.value if pair.one == one else 1.0 - pair.superiority.value
    p = "" if pair.p_adjusted is None else f", {chance(pair.p_adjusted)}"
    told = "can be told apart" if pair.significant else "cannot be told apart"
    return Duel(
        f"{value:.2f}",
        200 * (value - 0.5),
        pair.significant,
        f"{one} beats {other} in {100 * value:.0f} % of pairs; {told}{p}",
    )
