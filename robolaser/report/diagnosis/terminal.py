"""A diagnosis in twenty lines on the terminal."""

from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from robolaser.diagnosis.result import Diagnosis, Estimate
from robolaser.diagnosis.thresholds import CERTAIN
from robolaser.report.console import plain_unless_terminal, table
from robolaser.report.diagnosis import rows
from robolaser.report.diagnosis.advice import caveats, to_do
from robolaser.report.diagnosis.page import gap_lines
from robolaser.report.digits import millimetres, percent
from robolaser.report.setting import setting

MOST_CLASSES, MOST_EFFECTS, MOST_SITES, MOST_ADVICE = 3, 5, 2, 3
"""Lines of each."""
LEAST_SHARE = 5.0
"""Share in per cent, from which on a place is worth a line."""


def print_diagnosis(diagnosis: Diagnosis, folder: Path | None = None, *, console: Console | None = None) -> None:
    """Print verdict, gap, effects, sites and what to do; plain text unless on a terminal.

    Args:
        diagnosis: The result.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    out.print(Text(f"{diagnosis.dataset.name}: {setting(diagnosis.dataset)}", style="bold"))
    out.print(Text(diagnosis.sentence))
    for what, size, how in gap_lines(diagnosis):
        out.print(Text(f"  {what:<17} {size:>10}   ") + Text(how, style="dim"))
    if any(found.probability < CERTAIN for found in diagnosis.findings):
        for name, _, probability, gaps, _ in rows.class_rows(diagnosis)[:MOST_CLASSES]:
            out.print(Text(f"  {name:<17} {probability:>10}   {gaps}"))
    if diagnosis.findings:
        out.print(_effects(diagnosis))
    sites = [site for site in rows.site_rows(diagnosis) if site.share >= LEAST_SHARE]
    for site in sites[:MOST_SITES]:
        what = "of the rest" if diagnosis.verdict == "unexplained" else "of the gap"
        out.print(Text(f"{site.share:.0f} % {what} at {site.site} ({site.coordinate})", style="dim"))
    for advice in to_do(diagnosis)[:MOST_ADVICE]:
        out.print(Text(f"- {advice}"))
    for remark in diagnosis.noise_remarks:
        out.print(Text(remark, style="dim"))
    if untested := _untested(diagnosis):
        out.print(Text(f"Not testable: {', '.join(untested)}", style="dim"))
    if folder is not None:
        out.print(Text(f"Look at {folder / 'report.html'}"))


def _untested(diagnosis: Diagnosis) -> list[str]:
    """Effects that could be tested at none of their locations."""
    seen = [limit for limit in diagnosis.limits if limit.size is not None or limit.is_imitated]
    tested = {limit.candidate_effect.effect.name for limit in seen}
    tested |= {found.candidate_effect.effect.name for found in diagnosis.findings}
    return [name for name in diagnosis.not_testable if name not in tested]


def _effects(diagnosis: Diagnosis) -> Table:
    """A line for each effect, with the amplitude that is farthest from zero and the gravest caveat."""
    made = table("effect", "value", "probability", "gap without it")
    made.add_column("caveat")
    for found in diagnosis.findings[:MOST_EFFECTS]:
        amplitudes = [amplitude.name for amplitude in found.candidate_effect.effect.amplitudes()]
        name = max(amplitudes, key=lambda one: _clarity(found.parameters[one]))
        made.add_row(
            Text(f"{found.candidate_effect.effect.name}:{found.candidate_effect.where} {name}"),
            rows.with_error(found.parameters[name]),
            percent(found.probability),
            millimetres(found.gap_without_m),
            Text(caveats(diagnosis, found)[0], style="dim"),
        )
    left = len(diagnosis.findings) - MOST_EFFECTS
    if left > 0:
        made.add_row(Text(f"and {left} more"), "in diagnosis.json")
    return made


def _clarity(number: Estimate) -> float:
    return abs(number.value) / number.std if number.std else 0.0
