"""Where pictures are drawn: one look for all, as SVG that sits in a page and follows its colours."""

import io
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast, final

import matplotlib
from markupsafe import Markup, escape
from matplotlib.figure import Figure

WIDTH_PT, HEIGHT_PT = 420, 300
"""Small enough that letters stay readable on a phone, where the page shrinks a picture to its width."""

INK, MUTED, GRID, PAPER = "#212529", "#6c757e", "#dfe3e8", "#fefefd"
FITTED, HELD_OUT, NOISE = "#2b6cb1", "#d9701e", "#7d8791"
LINES = ("#2b6cb2", "#d9701f", "#2f8f5b", "#9a4fb0", "#b5352f", "#8a6d1f", "#1f8c99")
"""Of lines that are told apart."""

_VARIABLES = {
    INK: "--ink",
    MUTED: "--muted",
    GRID: "--grid",
    PAPER: "--paper",
    FITTED: "--fitted",
    HELD_OUT: "--held-out",
    NOISE: "--noise",
    **{colour: f"--line-{i}" for i, colour in enumerate(LINES)},
}
"""Colours that the page's style sheet decides on, for light and dark."""

_LOOK: dict[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "robolaser",
    "text.parse_math": False,
    "text.color": INK,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": MUTED,
    "axes.facecolor": "none",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": False,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "font.size": 9.5,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "lines.linewidth": 1.4,
}


@final
@dataclass(frozen=True)
class Picture:
    """A picture with what to look for in it.

    Attributes:
        title: A few words.
        svg: The drawing.
        caption: What it shows and what to look for.
    """

    title: str
    svg: Markup
    caption: str


def picture(
    title: str, caption: str, alt: str, paint: Callable[[Figure], None], *, height_pt: float = HEIGHT_PT
) -> Picture:
    """Draw.

    Args:
        title: A few words.
        caption: What to look for.
        alt: What a person sees who cannot see it.
        paint: Draws on an empty figure.
        height_pt: Of the picture.
    """
    with matplotlib.rc_context(cast(Any, _LOOK)), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # the reader's browser has its own fonts
        figure = Figure(figsize=(WIDTH_PT / 72, height_pt / 72), layout="constrained")
        paint(figure)
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None})
    return Picture(title, _inline(text.getvalue(), title, alt, height_pt), caption)


def _inline(svg: str, title: str, alt: str, height_pt: float) -> Markup:
    """The bare element, its ids unlike those of other pictures, its colours the page's."""
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    prefix = re.sub(r"\W+", "-", title.lower())
    body = re.sub(r'(\bid="|"#|url\(#)', rf"\g<1>{prefix}-", body)
    for colour, variable in _VARIABLES.items():
        body = body.replace(colour, f"var({variable})")
    head = f'<svg role="img" aria-label="{escape(alt)}" viewBox="0 0 {WIDTH_PT} {height_pt:g}">'
    return Markup(head + body[body.index(">") + 1 :])


def ticks(value: float, _: object = None) -> str:
    """A tick's number as people write it: 0.01, not 10⁻²."""
    return f"{value:.6g}".replace("-", "\u2212") if 1e-5 < abs(value) < 1e6 or value == 0 else f"{value:.0e}"


def plain_log(axis: Any) -> None:
    """Write a logarithmic axis's ticks as plain numbers, with 2 and 5 between the tens where there is room."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: PLC0415 - only here

    low, high = sorted(axis.get_view_interval())
    narrow = low > 0 and high / low < 300
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if narrow else (1,), numticks=12))
    axis.set_major_formatter(FuncFormatter(ticks))
    axis.set_minor_formatter(NullFormatter())


def spread(wanted: list[float], apart: float) -> list[float]:
    """Move heights of labels between 0 and 1 as little as need be for neighbours to be `apart`."""
    order = sorted(range(len(wanted)), key=lambda i: wanted[i])
    blocks: list[tuple[float, list[int]]] = []
    for i in order:
        blocks.append((wanted[i], [i]))
        while len(blocks) > 1:
            (low, a), (high, b) = blocks[-2:]
            if high - low >= apart * (len(a) + len(b)) / 2:
                break
            middle = (low * len(a) + high * len(b)) / (len(a) + len(b))
            blocks[-2:] = [(_inside(middle, len(a) + len(b), apart), a + b)]
    placed = list(wanted)
    for middle, members in blocks:
        for place, i in enumerate(members):
            placed[i] = middle + (place - (len(members) - 1) / 2) * apart
    return placed


def _inside(middle: float, labels: int, apart: float) -> float:
    half = (labels - 1) / 2 * apart
    return max(half, min(1.0 - half, middle))
