"""Names at the ends of lines, and how tall a picture must be for all of them."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robolaser.report.canvas import HEIGHT_PT, WIDTH_PT, spread

LINE_PT, LETTERS_PT = 10.5, 8.5
"""From one line of names to the next, and the size of their letters."""
BESIDE_PT = 60
"""Height of a picture that its axes leave for everything else."""
LETTERS = 25
"""Of a name that find room beside the lines; longer names are broken."""
LINES = 3
"""A name may take."""
LEAST_PLAIN, MOST_PLAIN = 0.99e-3, 1.01e5
"""Between which ticks are written out."""
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
JOINT = 1.05
"""Where a thread from a line's end meets its name, in widths of the axes."""


def broken(name: str, letters: int = LETTERS) -> list[str]:
    """A name in lines short enough, broken where it says something new, cut after a few lines."""
    lines = [""]
    for part in _parts(name):
        if lines[-1] and len(lines[-1]) + len(part) > letters:
            lines.append("")
        lines[-1] += part
    lines = [line if len(line) <= letters else f"{line[: letters - 1]}…" for line in lines]
    return lines if len(lines) <= LINES else [*lines[: LINES - 1], "…"]


def _parts(name: str) -> Sequence[str]:
    parts = [""]
    for letter in name:
        if letter in ":=./" and parts[-1]:
            parts.append("")
        parts[-1] += letter
        if letter == "-":
            parts.append("")
    return parts


def height_pt(names: Sequence[str]) -> float:
    """Of a picture beside whose lines all names find room."""
    return max(HEIGHT_PT, BESIDE_PT + LINE_PT * (1 + sum(len(broken(name)) for name in names)))


def beside_names(figure: Figure, names: Sequence[str]) -> Axes:
    """Axes that leave room for names on their right."""
    longest = max((len(line) for name in names for line in broken(name)), default=0)
    share = 1.0 - (4.6 * min(longest, LETTERS) + 24) / WIDTH_PT
    top = 1.0 - LINE_PT / 72 / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, 0, share, top))  # type: ignore[union-attr, call-arg]
    return figure.subplots()


def name_ends(ax: Axes, ends: Mapping[str, float], colours: Mapping[str, str], *, height: float) -> None:
    """Write names beside the axes, each level with its line's end or as near as the others let it.

    Args:
        ax: Lines end at its right edge.
        ends: Height of each line's end, 0 to 1 of the axes; of lines that end together, the first named is on top.
        colours: Of each.
        height: Of the picture [pt].
    """
    lines = [(name, text) for name in reversed(list(ends)) for text in reversed(broken(name))]
    wanted = [min(max(ends[name], 0.0), 1.0) for name, _ in lines]
    places = spread(wanted, LINE_PT / (height - BESIDE_PT))
    for name, end in ends.items():
        own = [(place, text) for (owner, text), place in zip(lines, places, strict=True) if owner == name]
        middle = sum(place for place, _ in own) / len(own)
        thread = ax.plot([1.0, JOINT], [end, middle], transform=ax.transAxes, color=colours[name], linewidth=0.7,
                         clip_on=False)  # fmt: skip
        thread[0].set_in_layout(False)
        for place, text in own:
            label = ax.text(JOINT + 0.01, place, text, transform=ax.transAxes, va="center", color=colours[name],
                            fontsize=LETTERS_PT)  # fmt: skip
            label.set_in_layout(False)


def decades(axis: Any, most: int) -> None:
    """Write a logarithmic axis's ticks as plain numbers as long as those are short, at most so many of them."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator  # noqa: PLC0415 - only here

    axis.set_major_locator(LogLocator(numticks=most))
    axis.set_major_formatter(FuncFormatter(_decade))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def _decade(value: float, _: object = None) -> str:
    if LEAST_PLAIN <= value < MOST_PLAIN:
        return f"{value:,.6g}"
    return f"10{str(round(math.log10(value))).translate(SUPERSCRIPT)}" if value > 0 else ""
