"""What planned poses could tell, as text: the smallest sizes, and the matrix of what is alike."""

import numpy as np
from rich.console import Console
from rich.text import Text

from robolaser.diagnosis.pose_plan import PosePlan
from robolaser.diagnosis.result import DetectionLimit
from robolaser.report.console import plain_unless_terminal, table
from robolaser.report.digits import millimetres, plain
from robolaser.report.setting import noise_lines

INSEPARABLE = 0.995
"""Correlation from which on a cell says that nothing tells two effects apart."""
DIGITS = 2
LEAST_SEEING = 0.7
"""Share of the poses, below which the cell that was guessed is not the one that they were planned for."""


def print_plan(plan: PosePlan, *, console: Console | None = None) -> None:
    """Print both tables; plain text unless on a terminal."""
    out = plain_unless_terminal(console)
    poses = len(plan.dataset.poses)
    seen = "" if plan.seeing == poses else f", {plan.seeing} of them see something"
    out.print(Text(f"{plan.dataset.name}: {plan.dataset.format.title}, {poses} poses{seen}", style="bold"))
    if plan.seeing < LEAST_SEEING * poses:
        out.print(Text("How the sensor will sit and where its target will stand is guessed, and here it does not fit."))
        out.print(Text("Measure once in some of these poses, and plan from that data set."))
    for name, what, size in noise_lines(plan.noise.sigmas, plan.noise.sources):
        if plan.noise.sigmas[name] > 0 or name in plan.silent:
            out.print(Text(f"  {name:<10} {size:>10}   ") + Text(what, style="dim"))
    sizes = table("effect", "where", "detectable from", "distinguishable from", "at the tool", "nearest other")
    for limit in plan.limits:
        sizes.add_row(*_row(limit))
    out.print(sizes)
    _print_matrix(plan, out)
    tried = {one.effect.name for one in plan.candidates}
    for name, reason in plan.untestable.items():
        if name not in tried:
            out.print(Text(f"Not testable: {name}: {reason}", style="dim"))


def _row(limit: DetectionLimit) -> tuple[str, ...]:
    one, rival = limit.candidate_effect, limit.rival
    size = "never" if limit.size is None else plain(limit.size, limit.unit, DIGITS)
    distinguishable = "never" if limit.identifiable is None else plain(limit.identifiable, limit.unit, DIGITS)
    at_tool = "" if limit.at_tool_m is None else millimetres(limit.at_tool_m)
    nearest = "" if rival is None else f"{rival.effect.name} {rival.where}"
    return one.effect.name, one.where, size, distinguishable, at_tool, nearest


def _print_matrix(plan: PosePlan, out: Console) -> None:
    names, alike = plan.of_effects()
    out.print(Text("Correlation of effects in %, at the locations where they are most alike; == cannot be told apart."))
    matrix = table("", "effect", *(str(number) for number in range(1, len(names) + 1)))
    for number, (name, row) in enumerate(zip(names, alike, strict=True), 1):
        matrix.add_row(str(number), name, *map(_cell, row.tolist()))
    out.print(matrix)


def _cell(correlation: float) -> str:
    if not np.isfinite(correlation):
        return ""
    return "==" if correlation >= INSEPARABLE else f"{100 * correlation:.0f}"
