"""The table of what each exchanged part does."""

from robolaser.benchmark.standings import Standings
from robolaser.benchmark.standings.answer import between, chance, figure, share
from robolaser.report.document import Cell, Column, Table


def effect_table(standings: Standings) -> Table | None:
    """A row for each exchanged part; None where no part is exchanged."""
    columns = [
        Column("Part", "name", 30, "part"),
        Column("In place of", "text"),
        Column("Better in so many pairs of runs", brief="better in"),
        Column("Times as many evaluations", brief="times the evaluations"),
        Column("p", brief="p"),
    ]
    rows = [
        (
            Cell(f"{effect.operator} as {effect.slot}"),
            f"{effect.stock}'s own",
            Cell(share(effect.superiority), order=effect.superiority.value),
            Cell(
                "–" if effect.ratio.value is None else f"{figure(effect.ratio.value)}{between(effect.ratio)}",
                order=effect.ratio.value,
            ),
            Cell(chance(effect.p_adjusted), order=effect.p_adjusted),
        )
        for effect in standings.effects
    ]
    if not rows:
        return None
    note = (
        "Runs with the part against runs without it that are alike in all else (problem, other parts), with 95 %"
        " intervals: 50 % of pairs is no effect; below 1 it reaches the target faster. p: van Elteren's test, by Holm"
        " for all parts."
    )
    return Table(columns, rows, "What each exchanged part does", note, printed=len(rows))
