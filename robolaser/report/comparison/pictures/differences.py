"""Which solvers can be told apart: the critical-difference diagram of Demšar (2006)."""

from collections.abc import Sequence
from math import ceil, floor

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robolaser.benchmark.standings import Ranks
from robolaser.benchmark.standings.phrases import chance
from robolaser.report.canvas import INK, MUTED, WIDTH_PT, Picture, picture
from robolaser.report.comparison.field import Field
from robolaser.report.comparison.pictures.ends import LETTERS_PT, LINE_PT, broken

HEAD_PT, BAR_PT, GAP_PT = 46.0, 7.0, 7.0
"""Heights: of the axis with the critical difference above it, of a bar, between names."""
SIDE_PT, LETTERS = 124.0, 23
"""Width that names have on either side, and letters that find room in a line of it."""


def differences(field: Field, ranks: Ranks, title: str) -> Picture | None:
    """Mean ranks on a line; bars join those that cannot be told apart."""
    names, means = ranks.algorithms, ranks.mean_ranks
    if len(names) < 3 or ranks.critical_difference is None:
        return None
    low, high = floor(min(means)), ceil(max(means))
    high = max(high, low + ceil(ranks.critical_difference))
    scale = (WIDTH_PT - 2 * SIDE_PT) / (high - low)
    levels = _levels([(names.index(group[0]), names.index(group[-1])) for group in ranks.groups])
    half = (len(names) + 1) // 2
    sides = (range(half), range(len(names) - 1, half - 1, -1))
    top = HEAD_PT + BAR_PT * (1 + max((level for _, _, level in levels), default=0)) + 12
    rows = [_rows([names[i] for i in side], top) for side in sides]
    height = max(end for _, end in rows) + 4

    def at(mean: float) -> float:
        return SIDE_PT + scale * (mean - low)

    def paint(figure: Figure) -> None:
        figure.set_layout_engine("none")
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set_axis_off()
        ax.set_xlim(0, WIDTH_PT)
        ax.set_ylim(height, 0)
        _axis(ax, [(at(rank), rank) for rank in range(low, high + 1)])
        width = scale * (ranks.critical_difference or 0.0)
        _bar(ax, at(low), at(low) + width, 14)
        ax.text(at(low) + width + 5, 14, f"critical difference {ranks.critical_difference:.1f}", va="center",
                color=MUTED, fontsize=LETTERS_PT)  # fmt: skip
        for first, last, level in levels:
            ax.plot([at(means[first]) - 3, at(means[last]) + 3], [HEAD_PT + BAR_PT * (level + 1)] * 2, color=INK,
                    linewidth=3.2, solid_capstyle="round", zorder=3)  # fmt: skip
        for side, (places, _), left in zip(sides, rows, (True, False), strict=True):
            for i, place in zip(side, places, strict=True):
                _name(ax, names[i], means[i], at(means[i]), place, field.colours.get(names[i], MUTED), left=left)

    return picture(
        title,
        f"Mean rank over {ranks.blocks} blocks, a problem and a seed each; left is better. Bars join solvers that"
        f" cannot be told apart at 5 % (Nemenyi's test; Friedman's over all: {_p(ranks)}).",
        f"Mean ranks from {names[0]}, {means[0]:.1f}, to {names[-1]}, {means[-1]:.1f}.",
        paint,
        height_pt=height,
    )


def _p(ranks: Ranks) -> str:
    return "p unknown" if ranks.p is None else chance(ranks.p)


def _levels(groups: Sequence[tuple[int, int]]) -> list[tuple[int, int, int]]:
    """Groups with the level that their bar is drawn on: those that overlap below each other."""
    ends: list[int] = []
    placed = []
    for first, last in sorted(groups):
        level = next((i for i, end in enumerate(ends) if end < first), len(ends))
        ends[level : level + 1] = [last]
        placed.append((first, last, level))
    return placed


def _rows(names: Sequence[str], top: float) -> tuple[list[float], float]:
    """Height of the first line of each name, and where they end [pt]."""
    places, at = [], top
    for name in names:
        places.append(at)
        at += LINE_PT * len(broken(name, LETTERS)) + GAP_PT
    return places, at


def _axis(ax: Axes, ticks: Sequence[tuple[float, int]]) -> None:
    ax.plot([ticks[0][0], ticks[-1][0]], [HEAD_PT, HEAD_PT], color=MUTED, linewidth=0.9)
    step = 1 if len(ticks) <= 13 else 2
    for x, rank in ticks[::step]:
        ax.plot([x, x], [HEAD_PT - 4, HEAD_PT], color=MUTED, linewidth=0.9)
        ax.text(x, HEAD_PT - 7, str(rank), ha="center", va="bottom", color=MUTED, fontsize=LETTERS_PT)


def _bar(ax: Axes, left: float, right: float, y: float) -> None:
    ax.plot([left, right], [y, y], color=INK, linewidth=1.2)
    for x in (left, right):
        ax.plot([x, x], [y - 3, y + 3], color=INK, linewidth=1.2)


def _name(ax: Axes, name: str, mean: float, x: float, y: float, colour: str, *, left: bool) -> None:
    """An elbow from the mean rank to the name at one side."""
    edge = SIDE_PT - 10 if left else WIDTH_PT - SIDE_PT + 10
    ax.plot([x, x, edge], [HEAD_PT, y, y], color=colour, linewidth=1.1)
    lines = broken(name, LETTERS)
    lines[-1] += f" {mean:.1f}" if len(lines[-1]) <= LETTERS - 3 else ""
    for i, line in enumerate(lines):
        ax.text(edge - 4 if left else edge + 4, y + LINE_PT * i, line, ha="right" if left else "left", va="center",
                color=colour, fontsize=LETTERS_PT)  # fmt: skip
