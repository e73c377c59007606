"""A comparison in twenty lines on the terminal."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.text import Text

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.report.comparison import methods, rows
from robolaser.report.comparison.page import document
from robolaser.report.comparison.plot_context import target
from robolaser.report.console import plain_unless_terminal, print_document, print_page

MOST_FAILURES, MOST_REFUSALS = 6, 3
"""Lines of each."""
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
    print_document(document(comparison, judged, brief=True), out)
    if missing := methods.missing(comparison):
        out.print(Text(missing, style="yellow"))
    for standings in judged if comparison.runs else ():
        aim = target(standings.family, standings.tolerance)
        out.print(Text(f"The target is {aim}.", style="dim"))
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
        print_page(folder, out)


def _short(reason: str) -> str:
    line = reason.splitlines()[0] if reason else ""
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"
