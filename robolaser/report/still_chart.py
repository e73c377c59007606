"""A chart as a still picture, for those whose browser runs no scripts: the marks of its specification as SVG."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from markupsafe import Markup, escape

from robolaser.report.chart import GRID, INK, MUTED, Chart, Spec

WIDTH, LEFT, RIGHT, BOTTOM, TOP = 540, 64, 12, 40, 26
NAMES: Final = 150
"""Room for names at the left [px]."""
LETTERS: Final = 22
BELOW: Final = 2000
"""A height that no chart has: where a line across all of it ends [px]."""
TICKS: Final = 5
At = Callable[[Any], float]
Axis = tuple[At, list[tuple[float, str]], str]


def still(chart: Chart) -> Markup:
    """The chart as SVG, without what answers to the pointer; empty where a browser has to compute its data."""
    layers, height = chart.spec["layer"], chart.spec["height"]
    if any("transform" in layer for layer in layers):
        return Markup("")
    named = any(layer["encoding"].get("y", {}).get("type") == "nominal" for layer in layers)
    left = NAMES if named else LEFT
    x, y = _axis(layers, "x", left, WIDTH - RIGHT), _axis(layers, "y", height - BOTTOM, TOP)
    legend = list(_legend(layers))
    parts = [*_grid(x, y, left, height), *(legend or [_text(4, TOP - 12, y[2], MUTED, "start")])]
    parts += [part for layer in layers for part in _marks(layer, x[0], y[0])]
    box = f'viewBox="0 0 {WIDTH} {height}" role="img" font-size="12" font-family="sans-serif"'
    return Markup(f"<svg {box}>{''.join(parts)}</svg>")


def _rows(layer: Spec, axis: str) -> Iterator[Any]:
    """All data values on an axis."""
    for name in (axis, f"{axis}2"):
        channel = layer["encoding"].get(name, {})
        if "field" in channel:
            values = (row.get(channel["field"]) for row in layer["data"]["values"])
            yield from (value for value in values if value is not None)


def _axis(layers: Sequence[Spec], axis: str, start: float, end: float) -> Axis:
    """Where a value stands [px], the ticks, and the title."""
    channel: Spec = next(
        (layer["encoding"][axis] for layer in layers if "field" in layer["encoding"].get(axis, {})), {}
    )
    values = [value for layer in layers for value in _rows(layer, axis)]
    title = str(channel.get("title") or "") if channel.get("axis", {}) is not None else ""
    if channel.get("type") in ("nominal", "ordinal"):
        names = list(dict.fromkeys([*(channel.get("sort") or []), *values]))
        place = {name: start + (end - start) * (i + 0.5) / len(names) for i, name in enumerate(names)}
        if axis == "y":  # names read from the top
            place = {name: start + end - at for name, at in place.items()}
        return place.__getitem__, [(at, str(name)[:LETTERS]) for name, at in place.items()], title
    scale = channel.get("scale", {})
    is_log = scale.get("type") == "log"
    values = [value for value in values if not is_log or value > 0] or [0.0, 1.0]
    low, high = scale.get("domain") or (min(values), max(values))
    if scale.get("reverse"):
        low, high = high, low
    turn: At = math.log10 if is_log else float
    span = turn(high) - turn(low) or 1.0

    def at(value: Any) -> float:
        share = (turn(max(value, 1e-300) if is_log else value) - turn(low)) / span
        return start + (end - start) * min(max(share, -0.02), 1.02)

    if channel.get("axis", {}) is None:
        return at, [], ""
    return at, [(at(tick), f"{tick:.4g}") for tick in _ticks(min(low, high), max(low, high), is_log=is_log)], title


def _ticks(low: float, high: float, *, is_log: bool) -> list[float]:
    if is_log:
        powers = [10.0**i for i in range(math.ceil(math.log10(low)), math.floor(math.log10(high)) + 1)]
        return powers[:: 1 + len(powers) // 8] if len(powers) > 1 else [low, *powers, high]
    rough = (high - low) / TICKS or 1.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * one for one in (1, 2, 5, 10) if power * one >= rough * 0.999)
    return [step * i for i in range(math.ceil(low / step), math.floor(high / step) + 1)]


def _grid(x: Axis, y: Axis, left: float, height: float) -> Iterator[str]:
    for at, text in x[1]:
        yield f'<path d="M{at:.1f} {TOP}V{height - BOTTOM}" stroke="{GRID}"/>'
        yield _text(at, height - BOTTOM + 16, text, MUTED, "middle")
    for at, text in y[1]:
        yield f'<path d="M{left} {at:.1f}H{WIDTH - RIGHT}" stroke="{GRID}"/>'
        yield _text(left - 6, at + 4, text, MUTED, "end")
    yield _text((left + WIDTH) / 2, height - 6, x[2], MUTED, "middle")


def _legend(layers: Sequence[Spec]) -> Iterator[str]:
    channels = (layer["encoding"].get("color", {}) for layer in layers)
    colour: Spec = next((channel for channel in channels if "legend" in channel), {})
    if colour.get("field") == "series" and colour.get("legend") is not None:
        names, at = colour["scale"]["domain"], 8.0
        for name, shade in zip(names, colour["scale"]["range"], strict=True):
            yield f'<circle cx="{at}" cy="10" r="4" fill="{escape(shade)}"/>'
            yield _text(at + 8, 14, str(name)[:LETTERS], INK, "start")
            at += 26 + 7 * min(len(str(name)), LETTERS)


def _marks(layer: Spec, x: At, y: At) -> Iterator[str]:
    """One layer's marks."""
    mark = layer["mark"] if isinstance(layer["mark"], dict) else {"type": layer["mark"]}
    kind, encoding = mark["type"], layer["encoding"]
    faint = f' opacity="{mark["opacity"]}"' if mark.get("opacity", 1) not in (0, 1) else ""
    groups: dict[str, list[tuple[float, float]]] = {}
    for row in layer["data"]["values"]:
        place = {name: _place(encoding, name, row, x if name[0] == "x" else y) for name in ("x", "y", "x2", "y2")}
        shade = escape(_shade(mark, encoding, row))
        left, top = place["x"], place["y"]
        if kind in ("line", "area"):
            if left is not None and top is not None:
                groups.setdefault(shade, []).append((left, top))
        elif kind == "rule":
            right, low = (place[f"{name}2"] if place[f"{name}2"] is not None else place[name] for name in ("x", "y"))
            ends = (left, top, right, low)
            x1, y1, x2, y2 = (whole if end is None else end
                              for end, whole in zip(ends, (LEFT, TOP, WIDTH - RIGHT, BELOW), strict=True))  # fmt: skip
            yield f'<path d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" stroke="{shade}"{faint}/>'
        elif left is None or top is None:
            continue
        elif kind == "text":
            yield _text(left + mark.get("dx", 0), top + mark.get("dy", 4), str(row.get(encoding["text"]["field"])),
                        str(shade), {"left": "start", "right": "end"}.get(mark.get("align", ""), "middle"))  # fmt: skip
        elif kind == "rect" and place["x2"] is not None and place["y2"] is not None:
            x1, x2 = sorted((left, place["x2"]))
            y1, y2 = sorted((top, place["y2"]))
            fill = "none" if mark.get("filled") is False else shade
            box = f'x="{x1:.1f}" y="{y1:.1f}" width="{x2 - x1:.1f}" height="{y2 - y1:.1f}"'
            yield f'<rect {box} fill="{fill}" stroke="{shade}"{faint}/>'
        elif kind in ("point", "tick"):
            size = 1.5 if kind == "tick" else math.sqrt(mark.get("size", 30)) / 2.2
            look = f'fill="none" stroke="{shade}"' if mark.get("filled") is False else f'fill="{shade}"'
            yield f'<circle cx="{left:.1f}" cy="{top:.1f}" r="{size:.1f}" {look}{faint}/>'
    for stroke, points in groups.items():
        steps = "step" in mark.get("interpolate", "")
        path = "".join(f"H{px:.1f}V{py:.1f}" if steps else f"L{px:.1f} {py:.1f}" for px, py in points[1:])
        start = f"M{points[0][0]:.1f} {points[0][1]:.1f}"
        yield f'<path d="{start}{path}" fill="none" stroke="{stroke}" stroke-width="1.5"/>'


def _place(encoding: Spec, name: str, row: Spec, at: At) -> float | None:
    channel = encoding.get(name, {})
    if "value" in channel:
        return float(channel["value"]) + (LEFT if name == "x" else TOP)
    value = channel.get("datum", row.get(channel.get("field", "")))
    return None if value is None else at(value)


def _shade(mark: Spec, encoding: Spec, row: Spec) -> str:
    colour = encoding.get("color", {})
    if colour.get("field") == "series":
        return str(
            dict(zip(colour["scale"]["domain"], colour["scale"]["range"], strict=True)).get(row["series"], MUTED)
        )
    if "range" in colour.get("scale", {}):
        low, *_, high = colour["scale"]["range"]
        return str(low if (row.get(colour["field"]) or 0.0) < 0 else high)
    return str(mark.get("color") or mark.get("stroke") or MUTED)


def _text(x: float, y: float, text: str, colour: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">{escape(text)}</text>' if text else ""
