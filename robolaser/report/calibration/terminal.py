"""A calibration in a few lines on the terminal."""

from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from robolaser.calibration.result import Calibration
from robolaser.report import words
from robolaser.report.evidence import Evidence
from robolaser.report.page import figures
from robolaser.report.rows import effect_rows, parameter_rows

MOST_ROWS = 16
WIDE = 160  # of text that goes to a file
STYLES = {"held-out": "bold", "noise": "", "fitted": "dim"}


def print_summary(calibration: Calibration, folder: Path | None = None, *, console: Console | None = None) -> None:
    """Print errors, parameters and where the rest is to be found; plain text where nobody looks on.

    Args:
        calibration: The result.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = console or Console(highlight=False)
    if not out.is_terminal:
        out = Console(file=out.file, highlight=False, width=WIDE, color_system=None)
    evidence = Evidence(calibration)
    out.print(Text(f"{calibration.model.dataset.name}: {words.setting(evidence)}", style="bold"))
    for figure in figures(evidence):
        line = Text(f"  {figure.label:<16} {figure.value:>10}   ", style=STYLES[figure.kind])
        out.print(line + Text(figure.remark, style="dim"))
    out.print(Text(words.judgement(evidence)))
    out.print(_parameters(calibration))
    if calibration.model.effects:
        out.print(_effects(calibration))
    for direction in calibration.unidentifiable:
        what = "do not tell apart" if len(direction.parameters) > 1 else "hardly fix"
        out.print(Text(f"These data {what}: {', '.join(direction.parameters)}", style="dim"))
    if folder is not None:
        out.print(Text(f"Look at {folder / 'report.html'}"))


def _parameters(calibration: Calibration) -> Table:
    given, placed = parameter_rows(calibration)
    rows = given or placed
    table = _table("parameter", "value", *(["nominal"] if given else []), "")
    for row in rows[:MOST_ROWS]:
        table.add_row(Text(row.name), row.value, *([row.nominal] if given else []), Text(row.note, style="dim"))
    left = len(given) + len(placed) - min(len(rows), MOST_ROWS)
    if left:
        table.add_row(Text(f"and {left} more"), "in calibration.json")
    return table


def _effects(calibration: Calibration) -> Table:
    table = _table("effect", "value", "")
    for row in effect_rows(calibration):
        table.add_row(Text(f"{row.effect}:{row.where} {row.number}"), row.value, Text(row.note, style="dim"))
    return table


def _table(*headings: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1), show_edge=False)
    for heading in headings:
        table.add_column(heading, no_wrap=True)
    return table
