"""Charts of a page: Vega-Lite specifications with one look, drawn by the reader's browser."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array

Spec = dict[str, Any]
Channel = dict[str, Any]

SCHEMA: Final = "https://vega.github.io/schema/vega-lite/v6.json"
HEIGHT_PX: Final = 280
LEAST_HEIGHT_PX, MOST_HEIGHT_PX = 150, 420
DIGITS = 5  # of the numbers that a page carries: finer than a pixel

INK, MUTED, GRID, PAPER = "var(--ink)", "var(--muted)", "var(--grid)", "var(--paper)"
FITTED, HELD_OUT, NOISE = "var(--fitted)", "var(--held-out)", "var(--noise)"
LINES = tuple(f"var(--line-{i})" for i in range(7))  # of the style sheet, which handles light and dark

FAINT = 0.06  # opacity of a series that the legend has switched off
SWITCH: Final[Spec] = {"select": {"type": "point", "fields": ["series"]}, "bind": "legend"}
"""Clicking a legend entry shows that series alone; Shift adds others."""
ZOOM: Final[Spec] = {"select": {"type": "interval", "zoom": "wheel![event.ctrlKey || event.metaKey]"}, "bind": "scales"}
"""Dragging moves the view, the wheel with Ctrl zooms, a double click resets."""

CONFIG: Final[Spec] = {  # one look for all charts
    "background": "transparent",
    "font": "system-ui, -apple-system, Segoe UI, Roboto, Helvetica Neue, Liberation Sans, Arial, sans-serif",
    "view": {"stroke": None},
    "axis": {
        "labelColor": MUTED, "titleColor": MUTED, "gridColor": GRID, "domainColor": MUTED, "ticks": False,
        "labelFontSize": 12, "titleFontSize": 12.5, "titleFontWeight": "normal", "labelPadding": 6, "titlePadding": 8,
        "labelOverlap": "greedy", "labelSeparation": 4, "labelLimit": 190,
    },
    "legend": {
        "labelColor": INK, "titleColor": MUTED, "labelFontSize": 12.5, "titleFontSize": 12.5,
        "titleFontWeight": "normal", "symbolStrokeWidth": 2, "labelLimit": 230, "symbolLimit": 0, "orient": "top",
        "columnPadding": 16, "symbolOpacity": 1,
    },
    "text": {"color": INK, "fontSize": 12.5},
    "point": {"filled": True, "opacity": 1},
}  # fmt: skip


@final
@dataclass(frozen=True)
class Chart:
    """A chart with what to look for in it."""

    title: str  # a few words
    caption: str  # what it shows and what to look for
    spec: Spec  # in Vega-Lite's language, with its data; its description is for screen readers

    @property
    def json(self) -> str:
        """The specification as text for a script element, safe for any names in the data."""
        return embedded(self.spec)


def embedded(values: Any) -> str:
    """JSON as text for a script element."""
    text = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def chart(
    title: str, caption: str, alt: str, layers: Sequence[Spec], *, height: float = HEIGHT_PX, zoomable: bool = True
) -> Chart:
    """Put layers on top of each other, the lowest first; that must have the legend, if any has.

    `alt` is the content in a sentence. The height is the plot's [px]; its width is the page's. Both axes of a zoomable
    chart must be continuous.
    """
    name = re.sub(r"\W+", "_", title)  # one specification may hold several charts
    params = [SWITCH | {"name": f"shown_{name}"}] if any(_by_series(one) for one in layers) else []
    params += [ZOOM | {"name": f"zoom_{name}"}] if zoomable else []
    first, *others = (_switchable(one, f"shown_{name}") for one in layers)
    spec = {
        "$schema": SCHEMA,
        "description": alt,
        "width": "container",
        "height": round(height),
        "autosize": {"type": "fit-x", "contains": "padding"},
        "layer": [first | {"params": params}, *others],
    }
    return Chart(title, caption, spec)


def layer(mark: str | Spec, data: Sequence[Spec] | str, **encoding: Channel | Sequence[Channel]) -> Spec:
    """One of Vega-Lite's marks for rows from `records`, or lines of comma-separated numbers below their names.

    The encoding is what each channel shows; `tooltip` is from `hover`.
    """
    values: Spec = {"values": data, "format": {"type": "csv"}} if isinstance(data, str) else {"values": data}
    return {"data": values, "mark": mark, "encoding": encoding}


def records(**columns: Any) -> list[Spec]:
    """Rows of columns of equal length; a single value is repeated; numbers that are not finite become null."""
    whole = np.broadcast_arrays(*(np.atleast_1d(np.asarray(column, object)) for column in columns.values()))
    return [dict(zip(columns, map(_value, row), strict=True)) for row in zip(*whole, strict=True)]


def quantity(field: str, title: str | None, *, log: bool = False, domain: Sequence[float] | None = None) -> Channel:
    """A channel that shows a number; `title` names its unit, None hides it."""
    scale: Spec = {"type": "log", "nice": False} if log else {"zero": False}
    if domain is not None:
        scale |= {"domain": [_number(end) for end in domain], "nice": False}
    elif log:
        scale |= {"padding": 14}
    axis: Spec = {"format": "~g", "tickCount": 6, "gridOpacity": 0.6} if log else {"tickCount": 7}
    return {"field": field, "type": "quantitative", "title": title, "scale": scale, "axis": axis}


TWO_LINES: Final = "indexof(datum.label, ' of ') > 0"


def named_rows(field: str) -> Channel:
    """A channel that names rows, from the top as they come; "backlash of joint_3" takes two lines."""
    axis = {"labelColor": INK, "domain": False, "labelOverlap": False, "labelExpr": "split(datum.label, ' of ')",
            "labelOffset": {"condition": {"test": TWO_LINES, "value": -7}, "value": 0}}  # fmt: skip
    return {"field": field, "type": "nominal", "sort": None, "title": None, "axis": axis}


def colours(of: Mapping[str, str], *, legend: Spec | None = None, shows_legend: bool = True) -> Channel:
    """The colour channel of data whose field `series` names the entry of the legend."""
    return {
        "field": "series",
        "type": "nominal",
        "title": None,
        "scale": {"domain": list(of), "range": list(of.values())},
        "legend": (legend or {}) if shows_legend else None,
    }


def hover(*names: str, **quantities: str) -> list[Channel]:
    """The tooltip of a mark: text fields by their names, numbers by their titles with units."""
    numbers = [
        {"field": field, "type": "quantitative", "title": title, "format": ",.4~g"}
        for field, title in quantities.items()
    ]
    return [*({"field": name, "type": "nominal"} for name in names), *numbers]


def line(*, step: bool = False, **more: Any) -> Spec:
    """The mark of a line whose points answer to the pointer."""
    interpolate = {"interpolate": "step-after"} if step else {}
    return {"type": "line", "clip": True, "point": {"opacity": 0, "size": 90}} | interpolate | more


def rule(**more: Any) -> Spec:
    """The mark of a dashed line across the plot."""
    return {"type": "rule", "strokeDash": [5, 4]} | more


def equal_axes(points: Array, titles: Sequence[str], *, margin: float = 0.06) -> tuple[Channel, Channel, float]:
    """Channels x and y with one scale for both at any width of the page, and a suitable height [px].

    All points, (n, 2), are visible, with a margin on each side, a share of the longer side. Titles have units.
    """
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    sides = high - low + 2 * margin * max(float((high - low).max()), 1e-9)
    height = round(np.clip(520 * sides[1] / sides[0], LEAST_HEIGHT_PX, MOST_HEIGHT_PX))
    per_px = f"max({sides[0]:.6g} / max(width, 1), {sides[1] / height:.6g})"
    channels = []
    for field, title, middle, side in zip("xy", titles, (low + high) / 2, ("width", f"{height}"), strict=True):
        channel = quantity(field, title)
        channel["scale"] = {"zero": False, "nice": False} | {
            end: {"expr": f"{middle:.8g} {sign} {side} / 2 * {per_px}"}
            for end, sign in (("domainMin", "-"), ("domainMax", "+"))
        }
        channels.append(channel)
    return channels[0], channels[1], height


def _by_series(one: Spec) -> bool:
    return bool(one["encoding"].get("color", {}).get("field") == "series")


def _switchable(one: Spec, param: str) -> Spec:
    if not _by_series(one):
        return one
    mark = one["mark"] if isinstance(one["mark"], dict) else {"type": one["mark"]}
    shown = mark.get("opacity", 1.0)
    channel = "strokeOpacity" if mark["type"] == "line" else "opacity"  # the points of a line are invisible
    opacity = {"condition": {"param": param, "value": shown}, "value": FAINT * shown}
    return one | {"encoding": {**one["encoding"], channel: opacity}}


def _value(value: Any) -> Any:
    return _number(value) if isinstance(value, float) else value


def _number(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
