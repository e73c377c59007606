"""What planned poses could tell, as text and as a page: the smallest sizes, and the matrix of what is alike."""

from collections.abc import Iterator, Mapping

import numpy as np

from robolaser.diagnosis.cause_words import named, place, spoken
from robolaser.diagnosis.pose_plan import PosePlan
from robolaser.diagnosis.result import DetectionLimit
from robolaser.report.chart import FITTED, INK, Chart, chart, hover, layer, records
from robolaser.report.digits import millimetres, plain
from robolaser.report.document import Block, Column, Document, Figure, Figures, Section, Table, Text, charts
from robolaser.report.setting import noise_lines, untestable

INSEPARABLE = 0.995
"""Correlation from which on a cell says that nothing tells two effects apart."""
DIGITS = 2
LEAST_SEEING = 0.7
"""Share of the poses, below which the cell that was guessed is not the one that they were planned for."""
ROW_PX, AROUND_PX = 26, 150
WHERE_IT_FITS = {"expr": "bandwidth('x') < 16 ? 0 : 1"}
"""Opacity of a cell's number, which is left to the pointer where cells are narrow, as on a phone."""
COLUMNS = ("effect", "where", "detectable from", "distinguishable from", "at the tool", "nearest other")
GUESSED = (
    "The poses of sensor and target are guesses, and too few of these poses see the target. Measure once in some"
    " of them, and plan from that data set."
)


def document(plan: PosePlan, *, command: str = "", brief: bool = False) -> Document:
    """The report.

    Args:
        plan: What it shows.
        command: What to type to repeat it.
        brief: For the terminal: with the matrix in numbers.
    """
    noise = [Figure("", name, size, what) for name, what, size in _noise(plan)]
    sizes = Table([Column(title, "name" if title == "effect" else "text", brief=title) for title in COLUMNS],
                  [_row(limit) for limit in plan.limits], printed=1000)  # fmt: skip
    untried = untestable(_untried(plan), "What these poses cannot test")
    return Document(
        plan.dataset.name,
        "planned",
        _setting(plan),
        _answer(plan),
        GUESSED if _is_guessed(plan) else "",
        [Figures(noise)] if noise else [],
        [
            Section("Smallest sizes", [sizes, untried]),
            Section("Which effects look alike", _matrix(plan) if brief else charts([_heat_map(plan)])),
        ],
        command=command,
    )


def _setting(plan: PosePlan) -> str:
    poses = len(plan.dataset.poses)
    seen = "" if plan.seeing == poses else f", {plan.seeing} of them see something"
    return f"{plan.dataset.format.title}, {poses} poses{seen}"


def _answer(plan: PosePlan) -> str:
    found = sum(limit.size is not None for limit in plan.limits)
    told = sum(limit.identifiable is not None for limit in plan.limits)
    return (
        f"Of {len(plan.limits)} possible faults, these poses would show {found}, and distinguish {told} of them from"
        " the most similar one."
    )


def _is_guessed(plan: PosePlan) -> bool:
    return plan.seeing < LEAST_SEEING * len(plan.dataset.poses)


def _noise(plan: PosePlan) -> Iterator[tuple[str, str, str]]:
    for name, what, size in noise_lines(plan.noise.sigmas, plan.noise.sources):
        if plan.noise.sigmas[name] > 0 or name in plan.silent:
            yield name.replace("_", " "), what, size


def _untried(plan: PosePlan) -> Mapping[str, str]:
    tried = {one.effect.name for one in plan.candidates}
    return {name: reason for name, reason in plan.untestable.items() if name not in tried}


def _heat_map(plan: PosePlan) -> Chart:
    names, alike = plan.of_effects()
    said = [spoken(name) for name in names]
    one, other = np.nonzero(np.isfinite(alike))
    data = records(
        effect=[said[i] for i in one],
        other=[said[i] for i in other],
        correlation=alike[one, other],
        cell=[_cell(alike[i, j]) for i, j in zip(one, other, strict=True)],
    )
    axes = {
        channel: {"field": field, "type": "nominal", "sort": said, "title": None, "axis": {"labelColor": INK}}
        for channel, field in (("x", "other"), ("y", "effect"))
    }
    depth = {"field": "correlation", "type": "quantitative", "scale": {"domain": [0, 1], "range": [0, 0.85]}}
    once = one <= other  # the matrix is symmetric
    worst = sum(row["cell"] == "==" for row, counts in zip(data, once, strict=True) if counts)
    return chart(
        "Correlation of effects in %",
        "At the locations where they are most alike; == marks indistinguishable effects.",
        f"Of {once.sum()} pairs of {len(names)} effects {worst} are indistinguishable.",
        [
            layer({"type": "rect", "color": FITTED}, data, **axes, opacity={**depth, "legend": None},
                  tooltip=hover("effect", "other", correlation="correlation")),
            layer({"type": "text", "fontSize": 11, "opacity": WHERE_IT_FITS}, data, **axes, text={"field": "cell"}),
        ],
        height=AROUND_PX + ROW_PX * len(names),
        zoomable=False,
    )  # fmt: skip


def _row(limit: DetectionLimit) -> tuple[str, ...]:
    one, rival = limit.candidate_effect, limit.rival
    size = "never" if limit.size is None else plain(limit.size, limit.unit, DIGITS)
    distinguishable = "never" if limit.identifiable is None else plain(limit.identifiable, limit.unit, DIGITS)
    at_tool = "" if limit.at_tool_m is None else millimetres(limit.at_tool_m)
    nearest = "" if rival is None else named(rival)
    return spoken(one.effect.name), place(one.where), size, distinguishable, at_tool, nearest


def _matrix(plan: PosePlan) -> list[Block]:
    """The heat map's numbers, for the terminal."""
    names, alike = plan.of_effects()
    said = "at the locations where they are most alike; == marks indistinguishable effects."
    heads = ["", "effect", *map(str, range(1, len(names) + 1))]
    numbered = enumerate(zip(names, alike.tolist(), strict=True), 1)
    rows = [(str(number), spoken(name), *map(_cell, row)) for number, (name, row) in numbered]
    matrix = Table([Column(head, brief=head) for head in heads], rows, printed=len(rows), kind="matrix")
    untried = [f"Not testable: {spoken(name)}: {reason}" for name, reason in _untried(plan).items()]
    return [
        Text(f"Correlation of effects in %, {said}", printed=True),
        matrix,
        *(Text(line, "quiet", printed=True) for line in untried),
    ]


def _cell(correlation: float) -> str:
    if not np.isfinite(correlation):
        return ""
    return "==" if correlation >= INSEPARABLE else f"{100 * correlation:.0f}"
