"""The cell drawn in a typical pose, the suspected places highlighted."""

from collections.abc import Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    INK,
    MUTED,
    PAPER,
    Chart,
    Spec,
    chart,
    equal_axes,
    hover,
    layer,
    records,
)
from robolaser.report.diagnosis.charts.outline import Outline

ELEVATION = np.radians(18.0)
"""How far from above the cell is looked at."""
FAN_LINES = 40
NEAR = 0.06
"""Distance, relative to the arm's size, below which joints share a label."""
LABEL_LENGTH, LABEL_RISE = 0.25, 0.03
"""Of a label, relative to the arm's size: how far it reaches, and how far above or below its symbol it stands."""
MARGIN = 0.12
"""Of the drawing, on each side, relative to its longer side."""
LEAST_SHARE = 0.1
"""Share from which on a place is suspected."""


def cell(diagnosis: Diagnosis) -> Chart:
    """Arm, sensor and target as seen from the side on which the arm spreads."""
    outline = Outline.of(diagnosis)
    marked = suspected(diagnosis)
    view = _view(outline)
    line = np.concatenate([outline.line, outline.tip[None]]) @ view
    positions = _positions(outline, view)
    seen = np.concatenate([line, outline.points @ view, outline.light @ view])
    x, y, height = equal_axes(seen, ("", ""), margin=MARGIN)
    for channel in (x, y):
        channel |= {"axis": None, "title": None}
    at = {"x": x, "y": y}
    named = ", ".join(f"{site} ({share})" if share else site for site, share in marked.items())
    what = (
        f"Highlighted: {named}."
        if marked
        else "No place is highlighted: what is left is noise."
        if diagnosis.verdict == "no_gap"
        else "No place is highlighted: the gap lies at none of them alone."
    )
    whose = "share of what is left" if diagnosis.verdict == "unexplained" else "share of the gap"
    brackets = f" In brackets: {whose} that lies there." if any(marked.values()) else ""
    return chart(
        "Where the gap lies",
        f"The cell in pose {outline.name}, one in the middle of those measured. {what}{brackets}",
        f"A line drawing of the cell. {what}",
        [
            *_target(outline, view, marked, at),
            *_light(outline, view, marked, at),
            *_arm(outline, line, marked, at),
            *_marks(positions, marked, at),
            *_labels(outline, line, positions, marked, at, _edges(seen)),
        ],
        height=height,
    )


def suspected(diagnosis: Diagnosis) -> Mapping[str, str]:
    """Places of the effects found and those where a gap lies, each with its share where it has one."""
    shares: dict[str, float] = {}
    for lies in diagnosis.where:
        shares[lies.site] = shares.get(lies.site, 0.0) + lies.share
    found = [finding.candidate_effect.where for finding in diagnosis.findings]
    sites = [*found, *(site for site, share in shares.items() if share >= LEAST_SHARE and not found)]
    if diagnosis.verdict == "unexplained":
        sites += [site for site, share in shares.items() if share >= LEAST_SHARE]
    return {site: f"{100 * min(1.0, shares[site]):.0f} %" if site in shares else "" for site in dict.fromkeys(sites)}


def _view(outline: Outline) -> Array:
    """From the base frame to the plane of the drawing, (3, 2): the arm spreads to the right, up is up."""
    seen = np.concatenate([outline.line, outline.tip[None], outline.points])
    flat = seen[:, :2] - seen[:, :2].mean(axis=0)
    across = np.linalg.svd(flat, full_matrices=False)[2][0] if np.ptp(flat) > 0 else np.array([1.0, 0.0])
    across = across * np.sign(across @ (outline.tip[:2] - outline.line[0, :2]) or 1.0)
    right = np.array([across[0], across[1], 0.0])
    away = np.array([-across[1], across[0], 0.0])
    up = np.array([0.0, 0.0, np.cos(ELEVATION)]) + np.sin(ELEVATION) * away
    return np.column_stack([right, up])


def _positions(outline: Outline, view: Array) -> Mapping[str, Array]:
    """Where in the drawing each site is, those that are somewhere in space."""
    positions = {name: outline.line[1 + i] for i, name in enumerate(outline.joints)}
    positions |= {"base": outline.line[0], "camera": outline.tip}
    if len(outline.points):
        positions["target"] = outline.points.mean(axis=0)
    positions["hand_eye" if outline.has_camera else "tool"] = (outline.line[-1] + outline.tip) / 2
    if len(outline.light):
        positions["laser"] = outline.light[0]
    return {site: position @ view for site, position in positions.items()}


def _edges(seen: Array) -> tuple[float, float]:
    """Left and right edge of the drawing."""
    margin = MARGIN * float(np.ptp(seen, axis=0).max())
    return float(seen[:, 0].min()) - margin, float(seen[:, 0].max()) + margin


def _target(outline: Outline, view: Array, marked: Mapping[str, str], at: Spec) -> list[Spec]:
    points = outline.points @ view
    mark = {"type": "point", "size": 8, "color": HELD_OUT if "target" in marked else MUTED, "opacity": 0.7}
    return [layer(mark, records(x=points[:, 0], y=points[:, 1]), **at)]


def _light(outline: Outline, view: Array, marked: Mapping[str, str], at: Spec) -> list[Spec]:
    """The laser plane as a fan from the projector."""
    if not len(outline.light):
        return []
    light = outline.light @ view
    ends = light[1:][np.argsort(light[1:, 0])]
    some = ends[np.linspace(0, len(ends) - 1, min(FAN_LINES, len(ends))).round().astype(int)]
    colour = HELD_OUT if "laser" in marked else FITTED
    fan = records(x=light[0, 0], y=light[0, 1], x2=some[:, 0], y2=some[:, 1])
    rays = {"type": "rule", "color": colour, "strokeWidth": 0.6, "opacity": 0.5}
    return [
        layer(rays, fan, x2={"field": "x2"}, y2={"field": "y2"}, **at),
        _path(ends, {"color": colour, "strokeWidth": 2}, at),
        _shape(light[:1], ["laser"], {"shape": "diamond", "stroke": colour}, at),
    ]


def _arm(outline: Outline, line: Array, marked: Mapping[str, str], at: Spec) -> list[Spec]:
    base, size = line[0], float(np.ptp(line, axis=0).max()) or 1.0
    ground = base + size * np.array([[-0.09, 0.0], [0.09, 0.0]])
    hand = "hand_eye" if outline.has_camera else "tool"
    layers = [_path(ground, {"color": _colour("base", marked), "strokeWidth": 5}, at)]
    if outline.joints:
        layers.append(_path(line[:-1], {"color": MUTED, "strokeWidth": 7, "opacity": 0.45}, at))
    layers.append(_path(line[-2:], {"color": _colour(hand, marked), "strokeWidth": 3}, at))
    innocent = [i for i, name in enumerate(outline.joints) if name not in marked]
    if innocent:
        layers.append(
            _shape(line[[1 + i for i in innocent]], [outline.joints[i] for i in innocent], {"stroke": MUTED}, at)
        )
    if outline.has_camera and "camera" not in marked:
        layers.append(_shape(line[-1:], ["camera"], {"shape": "square", "stroke": INK}, at))
    return layers


def _marks(positions: Mapping[str, Array], marked: Mapping[str, str], at: Spec) -> list[Spec]:
    here = [site for site in marked if site in positions]
    dots = [site for site in here if site != "target"]
    if not dots:
        return []
    where = np.stack([positions[site] for site in dots])
    data = records(x=where[:, 0], y=where[:, 1], site=dots, share=[marked[site] for site in dots])
    return [
        layer(
            {"type": "point", "size": 190, "color": HELD_OUT, "opacity": 1}, data, tooltip=hover("site", "share"), **at
        )
    ]


def _labels(
    outline: Outline,
    line: Array,
    positions: Mapping[str, Array],
    marked: Mapping[str, str],
    at: Spec,
    edges: tuple[float, float],
) -> list[Spec]:
    """Names of the highlighted places beside them, or in a corner for those nowhere in space; of other joints small."""
    layers = []
    bold = {"type": "text", "align": "left", "color": HELD_OUT, "fontWeight": "bold"}
    size = float(np.ptp(line, axis=0).max()) or 1.0
    for site in (site for site in marked if site in positions):
        text = records(x=float(positions[site][0]), y=float(positions[site][1]), label=_label(site, marked))
        symbols = np.stack([line[-1], *(position for name, position in positions.items() if name != site)])
        side = beside(positions[site], symbols, size, edges)
        layers.append(layer(bold | side, text, text={"field": "label"}, **at))
    for i, site in enumerate(site for site in marked if site not in positions):
        corner = {"x": {"value": 4}, "y": {"value": 12 + 17 * i}}
        layers.append(layer(bold, records(label=_label(site, marked)), text={"field": "label"}, **corner))
    others = _other_joints(outline, line, marked)
    if others:
        where = np.stack([position for _, position in others])
        data = records(x=where[:, 0], y=where[:, 1], label=[label for label, _ in others])
        small = {"type": "text", "align": "right", "dx": -12, "dy": -9, "color": MUTED, "fontSize": 11}
        layers.append(layer(small, data, text={"field": "label"}, **at))
    return layers


def beside(position: Array, others: Array, size: float, edges: tuple[float, float]) -> Spec:
    """On which side of a symbol its label has the most room, right and below if on both; others (n, 2)."""

    def room(side: tuple[int, int]) -> float:
        if not edges[0] <= position[0] + side[0] * size * LABEL_LENGTH <= edges[1]:
            return -1.0
        along = np.linspace(0.0, LABEL_LENGTH, 8)[:, None] * (side[0], 0.0) + np.array([0.0, LABEL_RISE * side[1]])
        return round(float(np.linalg.norm(others - (position + size * along)[:, None], axis=-1).min() / size), 2)

    right, up = max(((1, -1), (1, 1), (-1, -1), (-1, 1)), key=room)
    return {"align": "left" if right > 0 else "right", "dx": 13 * right, "dy": -11 if up > 0 else 15}


def _other_joints(outline: Outline, line: Array, marked: Mapping[str, str]) -> list[tuple[str, Array]]:
    """Names of joints that are not suspected, those at one place in one label."""
    near = NEAR * float(np.ptp(line, axis=0).max())
    labels: list[tuple[str, Array]] = []
    for name, at in zip(outline.joints, line[1:], strict=False):
        if name in marked:
            continue
        if labels and np.linalg.norm(at - labels[-1][1]) < near:
            labels[-1] = (f"{labels[-1][0]}, {name}", labels[-1][1])
        else:
            labels.append((name, at))
    return labels


def _path(positions: Array, look: Spec, at: Spec) -> Spec:
    data = records(x=positions[:, 0], y=positions[:, 1], order=np.arange(len(positions)))
    mark = {"type": "line", "strokeCap": "round", "strokeJoin": "round"} | look
    return layer(mark, data, order={"field": "order", "type": "quantitative"}, **at)


def _shape(positions: Array, names: list[str], look: Spec, at: Spec) -> Spec:
    mark = {"type": "point", "size": 80, "fill": PAPER, "strokeWidth": 2, "opacity": 1} | look
    return layer(mark, records(x=positions[:, 0], y=positions[:, 1], site=names), tooltip=hover("site"), **at)


def _label(site: str, marked: Mapping[str, str]) -> str:
    return f"{site} {marked[site]}".rstrip()


def _colour(site: str, marked: Mapping[str, str]) -> str:
    return HELD_OUT if site in marked else INK
