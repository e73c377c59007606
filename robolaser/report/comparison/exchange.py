"""Effects of exchanged parts in words."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from robolaser.benchmark.standings.phrases import chance, figure

if TYPE_CHECKING:
    import pandas as pd


def effect_lines(effects: "pd.DataFrame") -> Iterator[str]:
    """A line for each row of `robolaser.benchmark.exchange.effects`."""
    for row in effects.itertuples():
        better = (
            f"better in {row.superiority:.0%} ({row.superiority_lower:.0%} to {row.superiority_upper:.0%}) of pairs"
        )
        needs = ""
        if math.isfinite(row.ratio):
            end = f"to {figure(row.ratio_upper)}" if math.isfinite(row.ratio_upper) else "or more"
            known = f" ({figure(row.ratio_lower)} {end})" if not math.isnan(row.ratio_lower) else ""
            needs = f", {figure(row.ratio)}{known} times as many evaluations to the target"
        yield f"{row.stock} with {row.operator} as {row.slot}: {better}{needs}, {chance(row.p_adjusted)}"
