"""The table of what runs have found after so many evaluations."""

from robolaser.benchmark.fixed import fixed_budget
from robolaser.benchmark.problem import ProblemSummary
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.comparison.ranking import line_number, quartile_cell
from robolaser.report.document import Cell, Column, Table

SHARES = (0.01, 0.1, 1.0)
"""Of the budget that each have a column."""


def budget_table(context: PlotContext, problem: ProblemSummary) -> Table:
    """Fixed budgets: how far above the best known each algorithm is, in the order of their ranking."""
    budgets = sorted({max(1, round(share * context.comparison.budget)) for share in SHARES})
    frame = fixed_budget(context.comparison, budgets, [problem])
    rows = []
    for name in context.order:
        of = frame[frame.algorithm == name]
        if len(of):
            cells = [quartile_cell(context, problem, row.lower, row.median, row.upper) for row in of.itertuples()]
            rows.append([Cell(name, line=line_number(context, name)), *cells])
    columns = [Column("Algorithm", "name", 23), *(Column(f"After {budget:,} evaluations") for budget in budgets)]
    return Table(columns, rows, "Fixed budgets: above the best known, median and quartiles")
