"""A calibration in a few lines on the terminal."""

from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from robolaser.calibration.result import Calibration
from robolaser.report.calibration import words
from robolaser.report.calibration.error_analysis import ErrorAnalysis
from robolaser.report.calibration.page import figures
from robolaser.report.calibration.rows import effect_rows, parameter_rows
from robolaser.report.console import plain_unless_terminal, table
from robolaser.report.setting import setting

MOST_ROWS = 16
FOR_ROS = ("camera.yaml", "robot.urdf", "static_transform.sh", "easy_handeye2.calib")
STYLES = {"held-out": "bold", "noise": "", "fitted": "dim"}


def print_summary(calibration: Calibration, folder: Path | None = None, *, console: Console | None = None) -> None:
    """Print errors, parameters and where the page is; plain text unless on a terminal.

    Args:
        calibration: The result.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    analysis = ErrorAnalysis(calibration)
    out.print(Text(f"{calibration.model.dataset.name}: {setting(calibration.model.dataset)}", style="bold"))
    for figure in figures(analysis):
        line = Text(f"  {figure.label:<16} {figure.value:>10}   ", style=STYLES[figure.kind])
        out.print(line + Text(figure.remark, style="dim"))
    out.print(Text(words.judgement(analysis)))
    out.print(_parameters(calibration))
    if calibration.model.effects:
        out.print(_effects(calibration))
    together = [", ".join(found.parameters) for found in calibration.unidentifiable if len(found.parameters) > 1]
    alone = [found.parameters[0] for found in calibration.unidentifiable if len(found.parameters) == 1]
    if together:
        out.print(Text(f"These data cannot separate: {'; '.join(together)}", style="dim"))
    if alone:
        out.print(Text(f"These data hardly determine: {', '.join(alone)}", style="dim"))
    if folder is not None:
        if (folder / "static_transform.sh").exists():
            *files, last = (name for name in FOR_ROS if (folder / name).exists())
            out.print(Text(f"For ROS: {', '.join(files)} and {last} in {folder}", style="dim"))
        out.print(Text(f"Look at {folder / 'report.html'}"))


def _parameters(calibration: Calibration) -> Table:
    given, placed = parameter_rows(calibration)
    rows = given or placed
    made = table("parameter", "value", *(["nominal"] if given else []), "")
    for row in rows[:MOST_ROWS]:
        made.add_row(Text(row.name), row.value, *([row.nominal] if given else []), Text(row.note, style="dim"))
    left = len(given) + len(placed) - min(len(rows), MOST_ROWS)
    if left:
        made.add_row(Text(f"and {left} more"), "in calibration.json")
    return made


def _effects(calibration: Calibration) -> Table:
    made = table("effect", "value", "")
    for row in effect_rows(calibration):
        made.add_row(Text(f"{row.effect}:{row.where} {row.number}"), row.value, Text(row.note, style="dim"))
    return made
