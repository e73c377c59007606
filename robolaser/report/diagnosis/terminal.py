"""A diagnosis in twenty lines on the terminal."""

from pathlib import Path

from rich.console import Console
from rich.text import Text

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.console import plain_unless_terminal, print_document, print_page
from robolaser.report.diagnosis.page import document


def print_diagnosis(diagnosis: Diagnosis, folder: Path | None = None, *, console: Console | None = None) -> None:
    """Print verdict, gap, effects, sites and what to do; plain text unless on a terminal.

    Args:
        diagnosis: The result.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    print_document(document(diagnosis, brief=True), out)
    if untested := _untested(diagnosis):
        out.print(Text(f"Not testable: {', '.join(untested)}", style="dim"))
    if folder is not None:
        print_page(folder, out)


def _untested(diagnosis: Diagnosis) -> list[str]:
    """Effects that could be tested at none of their locations."""
    seen = [limit for limit in diagnosis.limits if limit.size is not None or limit.is_imitated]
    tested = {limit.candidate_effect.effect.name for limit in seen}
    tested |= {found.candidate_effect.effect.name for found in diagnosis.findings}
    return [name.replace("_", " ") for name in diagnosis.not_testable if name not in tested]
