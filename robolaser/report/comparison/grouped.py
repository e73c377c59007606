"""Tables of many problems, which leave no room for a section each."""

import re
from collections.abc import Sequence

from robolaser.benchmark.standings.table import OnProblem
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.comparison.ranking import reached, result_table
from robolaser.report.document import Cell, Column, Table


def group_table(context: PlotContext) -> Table:
    """A row for all problems of one name, whatever their settings: who is first how often, and reaches the target."""
    groups: dict[str, list[OnProblem]] = {}
    for on in context.standings.by_problem:
        groups.setdefault(re.sub(r"(:\w+=[^:]*)+$", "", on.problem), []).append(on)
    names = [name for name in context.order if name in context.coloured]
    rows = [
        (
            Cell(group, below=[context.contested(of[0].problem).title, f"{len(of)} problems"][: len(of)]),
            *(_record(context, of, name) for name in names),
        )
        for group, of in groups.items()
    ]
    note = f"Target: {context.target(context.standings.tolerance)}. First by evaluations; equal ranks count for each."
    return Table([Column("Problems", "name", 23), *map(Column, names)], rows, "Who is first where", note, len(rows))


def _record(context: PlotContext, of: Sequence[OnProblem], name: str) -> Cell:
    first = sum(place.rank == 1 for on in of for place in on.evaluations.places if place.algorithm == name)
    results = [result for on in of for result in on.results if result.algorithm == name]
    hits = sum(one.successes for result in results if (one := reached(result, context.standings.tolerance)))
    runs = sum(result.runs for result in results)
    return Cell(f"{first} of {len(of)}", (f"target in {hits} of {runs} runs",) if runs else (), order=first)


def all_results(context: PlotContext) -> Table:
    """All algorithms on all problems, folded away."""
    tables = {on.problem: result_table(context, on) for on in context.standings.by_problem}
    columns = max((table.columns for table in tables.values()), key=len)
    rows = [
        (Cell(f"{context.number(problem)}. {problem}"), *row, *[Cell("")] * (len(columns) - len(row)))
        for problem, table in tables.items()
        for row in table.rows
    ]
    return Table(
        [Column("Problem", "name", 23), *columns], rows, "Fixed targets and final results on each problem", fold=0
    )
