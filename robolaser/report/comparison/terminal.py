"""A comparison in twenty lines on the terminal."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.report.comparison import methods, rows
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.comparison.ranking import standing_rows
from robolaser.report.console import plain_unless_terminal, table

MOST_PLACES, MOST_FAILURES, MOST_REFUSALS = 12, 6, 3
"""Lines of each."""
FEWEST_PLACES = 4
"""Lines of each family, if there are several."""
NAME = 24
"""Letters of a name that stay in a line."""
LONGEST = 90
"""Letters of a reason that are worth printing."""


def print_comparison(
    comparison: BenchmarkResult,
    judged: Sequence[Standings],
    folder: Path | None = None,
    *,
    console: Console | None = None,
) -> None:
    """Print setting, verdict, standings and failures; plain text unless on a terminal.

    Args:
        comparison: What was run.
        judged: The standings of each family of problems.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    names = ", ".join(problem.name for problem in comparison.problems)
    out.print(Text(f"{names}: {methods.setting(comparison)}", style="bold"))
    if missing := methods.missing(comparison):
        out.print(Text(missing, style="yellow"))
    for standings in judged if comparison.runs else ():
        context = PlotContext(comparison, standings)
        if len(judged) > 1:
            out.print(Text(f"{methods.FAMILIES.get(standings.family, standings.family)}:", style="bold"))
        out.print(Text(standings.evaluations.answer))
        out.print(Text(f"The target is {context.target(standings.tolerance)}.", style="dim"))
        out.print(_standings(context, max(FEWEST_PLACES, MOST_PLACES // len(judged))))
    failures = [
        f"{name}: {count} {'run' if count == 1 else 'runs'} failed, {_short(reason)}"
        for name, reason, count, _ in rows.failure_rows(comparison)
    ]
    refusals = [
        f"{name} was not run on {where}: {_short(reason)}" for name, where, reason in rows.refusal_rows(comparison)
    ]
    for lines, most in ((failures, MOST_FAILURES), (refusals, MOST_REFUSALS)):
        for line in lines[:most]:
            out.print(Text(line, style="dim"))
        if len(lines) > most:
            out.print(Text(f"and {len(lines) - most} more, see the report", style="dim"))
    if not comparison.wanted:
        out.print(Text("No algorithm could be run on any of the problems."))
    if folder is not None:
        out.print(Text(f"Look at {folder / 'report.html'}"))


def _standings(context: PlotContext, most: int) -> Table:
    """A line for each algorithm."""
    made = table("rank", "algorithm", "success", "evaluations", "time", "worse than the first?", "failed")
    made.columns[1].no_wrap, made.columns[1].min_width = False, NAME
    shown = standing_rows(context)
    for row in shown[:most]:
        success = " ".join([row.success.shown, *(f"({line})" for line in row.success.below[:1])])
        against = ", ".join([row.against.shown, *row.against.below[:1]])
        made.add_row(
            row.rank,
            Text(row.name, overflow="fold"),
            success,
            row.evaluations.shown,
            row.seconds.shown,
            against,
            row.failed,
        )
    if len(shown) > most:
        made.add_row("", f"and {len(shown) - most} more")
    return made


def _short(reason: str) -> str:
    line = reason.splitlines()[0] if reason else ""
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"
