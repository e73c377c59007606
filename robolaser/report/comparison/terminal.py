"""A comparison in twenty lines on the terminal."""

from collections.abc import Sequence
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.report.comparison import account, rows
from robolaser.report.comparison.field import Field
from robolaser.report.comparison.ranking import standing_rows

WIDE = 160  # of text that goes to a file
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
    """Print setting, verdict, standings and failures; plain text where nobody looks on.

    Args:
        comparison: What was run.
        judged: How solvers stand, for each family of problems.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = console or Console(highlight=False)
    if not out.is_terminal:
        out = Console(file=out.file, highlight=False, width=WIDE, color_system=None)
    names = ", ".join(problem.name for problem in comparison.problems)
    out.print(Text(f"{names}: {account.setting(comparison)}", style="bold"))
    if missing := account.missing(comparison):
        out.print(Text(missing, style="yellow"))
    for standings in judged if comparison.runs else ():
        field = Field(comparison, standings)
        if len(judged) > 1:
            out.print(Text(f"{account.FAMILIES.get(standings.family, standings.family)}:", style="bold"))
        out.print(Text(standings.evaluations.answer))
        out.print(Text(f"The target is {field.target(standings.tolerance)}.", style="dim"))
        out.print(_standings(field, max(FEWEST_PLACES, MOST_PLACES // len(judged))))
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
        out.print(Text("Nobody has anything to say on any of the problems."))
    if folder is not None:
        out.print(Text(f"Look at {folder / 'report.html'}"))


def _standings(field: Field, most: int) -> Table:
    """A line for each solver."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1), show_edge=False)
    for heading in ("", "solver", "success", "evaluations", "time", "told from the first?", "failed"):
        table.add_column(heading, no_wrap=heading != "solver", min_width=NAME if heading == "solver" else None)
    shown = standing_rows(field)
    for row in shown[:most]:
        success = " ".join([row.success.shown, *(f"({line})" for line in row.success.below[:1])])
        told = ", ".join([row.against.shown, *row.against.below[:1]])
        table.add_row(
            row.rank,
            Text(row.name, overflow="fold"),
            success,
            row.evaluations.shown,
            row.seconds.shown,
            told,
            row.failed,
        )
    if len(shown) > most:
        table.add_row("", f"and {len(shown) - most} more")
    return table


def _short(reason: str) -> str:
    line = reason.splitlines()[0] if reason else ""
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"
