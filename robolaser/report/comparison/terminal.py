"""A comparison in twenty lines on the terminal."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.text import Text

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.report.comparison import tables, words
from robolaser.report.comparison.page import document
from robolaser.report.console import plain_unless_terminal, print_document, print_page

MOST_FAILURES, MOST_TARGETS = 6, 8
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
    """Print setting, verdict, standings, targets and failures; plain text unless on a terminal.

    Args:
        comparison: What was run.
        judged: The standings of each family of problems.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    print_document(document(comparison, judged, brief=True), out)
    if missing := words.missing(comparison):
        out.print(Text(missing, style="yellow"))
    aims = [line for one in judged for line in words.aims(comparison, one)] if comparison.runs else []
    knowing = [name for name in comparison.solvers if name in comparison.know_budget]
    notes = [f"{', '.join(knowing)}: searches differently with another budget."] if knowing else []
    notes += [
        f"{one.name} is noisy: runs are ranked by what they returned, evaluated anew."
        for one in comparison.problems
        if one.noisy
    ]
    failures = [
        f"{name}: {count} {'run' if count == 1 else 'runs'} failed, {_short(reason)}"
        for name, reason, count, _ in tables.failure_rows(comparison)
    ]
    failures += [
        f"{name} was not run on {where}: {_short(why)}" for name, where, why in tables.refusal_rows(comparison)
    ]
    for lines, most in ((aims, MOST_TARGETS), (notes, MOST_TARGETS), (failures, MOST_FAILURES)):
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
