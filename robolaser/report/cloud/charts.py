"""A cloud from above: its heights, its scatter, and how far its points lie off the largest plane."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array
from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, equal_axes, hover, layer, quantity, records
from robolaser.scan.primitives import rms_m
from robolaser.scan.quality import Quality

CELLS = 110, 90, 60, 45  # along the longer side of a map; the finest that leaves no gaps between stripes
FILLED = 0.95  # of the area that the coarsest cells cover
CLEAR = 1.0, 99.0  # percentiles between which colours are spread: a stray point would take them all
BINS = 60
FEWEST = 10  # points that make a chart


def heights(quality: Quality) -> Chart | None:
    """The cloud seen along the direction in which it is thinnest, coloured by how far it stands out."""
    if len(quality.vertices) < FEWEST:
        return None
    across, along, out, what = _view(quality)
    caption = (
        f"Each cell is the mean of the points in it, {what}. Steps between neighbouring stripes, or copies of one edge,"
        " mean that the calibration does not fit this recording."
    )
    return _map("Heights", caption, across, along, 1e3 * out, "viridis", "height [mm]")


def scatter(quality: Quality) -> Chart | None:
    """The same view, coloured by the scatter of its points."""
    std = quality.vertices["std"].astype(np.float64)
    if len(std) < FEWEST or not np.isfinite(std).all():
        return None
    across, along, _, _ = _view(quality)
    caption = (
        "What noise does to a point: that of the line centre carried through ray and laser plane, that of the joints"
        " through the arm. It grows where rays meet the laser plane at a shallow angle. What the calibrated model did"
        " not explain counts as noise of the joints; errors that all points share are not in it."
    )
    return _map("Scatter of the points", caption, across, along, 1e3 * std, "viridis", "std [mm]")


def off_plane(quality: Quality) -> Chart | None:
    """How far the plane's points lie off it, against what their scatter predicts."""
    plane = quality.plane
    if plane is None:
        return None
    off = 1e3 * plane.distance[plane.on]
    std = 1e3 * quality.vertices["std"].astype(np.float64)[plane.on]
    limit = 1.5 * float(np.percentile(np.abs(off), CLEAR[1])) or 1.0
    edges = np.linspace(-limit, limit, BINS + 1)
    centres = (edges[1:] + edges[:-1]) / 2
    width = edges[1] - edges[0]
    share = 100 * np.histogram(off, edges)[0] / len(off)
    measured, predicted = "measured", "predicted by std"
    x = quantity("distance", "distance from the plane [mm]", domain=(-limit, limit))
    y = quantity("share", "share of the points [%]")
    colour = colours({measured: FITTED, predicted: HELD_OUT})
    said = hover("series", distance="distance [mm]", share="share of the points [%]")
    bars = {"type": "rect", "opacity": 0.6}
    found = records(distance=edges[:-1], to=edges[1:], share=share, series=measured)
    layers = [layer(bars, found, tooltip=said, x=x, x2={"field": "to"}, y=y, y2={"datum": 0}, color=colour)]
    if np.isfinite(std).all() and (std > 0).all():
        some = std[:: max(1, len(std) // 2000), None]
        normal = (np.exp(-0.5 * (centres / some) ** 2) / (np.sqrt(2 * np.pi) * some)).mean(axis=0)
        curve = records(distance=centres, share=100 * width * normal, series=predicted)
        layers.append(layer({"type": "line", "clip": True}, curve, tooltip=said, x=x, y=y, color=colour))
    return chart(
        "Points about the largest plane",
        "Distances of the points that lie on the largest plane. Wider than predicted: the stripes do not agree with"
        " each other, and the calibration contributes; narrower: the surface is nearly parallel to the error, or the"
        " calibration took for noise what its model did not explain.",
        f"Histogram of {int(plane.on.sum())} distances from a plane, root mean square {1e3 * rms_m(plane):.3g} mm.",
        layers,
    )


CHARTS: tuple[Callable[[Quality], Chart | None], ...] = (heights, scatter, off_plane)


def _view(quality: Quality) -> tuple[tuple[str, Array], tuple[str, Array], Array, str]:
    """Names and values of what is drawn to the right and up, what stands out, and how to say it."""
    positions = quality.positions
    low, high = np.percentile(positions, CLEAR, axis=0)
    thin = int(np.argmin(high - low))
    right, up = (axis for axis in range(3) if axis != thin)
    names = tuple("xyz"[axis] for axis in (right, up))
    across, along = (names[0], positions[:, right]), (names[1], positions[:, up])
    if quality.plane is not None:
        return across, along, quality.plane.distance, "above the largest plane"
    return across, along, positions[:, thin], f"by its {'xyz'[thin]} in the base frame"


def _map(
    title: str, caption: str, across: tuple[str, Array], along: tuple[str, Array], value: Array, scheme: str, unit: str
) -> Chart:
    sides = [1e3 * np.percentile(one, CLEAR) for _, one in (across, along)]
    margin = 0.03 * max(float(np.ptp(side)) for side in sides) or 1.0
    (left, right), (low, high) = ((side[0] - margin, side[1] + margin) for side in sides)
    positions = 1e3 * across[1], 1e3 * along[1]
    edges = _edges(positions, (left, right), (low, high))
    count = np.histogram2d(*positions, bins=edges)[0]
    total = np.histogram2d(*positions, bins=edges, weights=value)[0]
    i, j = np.nonzero(count)
    mean = total[i, j] / count[i, j]
    size = float(edges[0][1] - edges[0][0])
    rows = zip(edges[0][i], edges[1][j], mean, strict=True)
    data = "x,y,value\n" + "".join(f"{a:.5g},{b:.5g},{c:.4g}\n" for a, b, c in rows)
    least, most = np.percentile(mean, CLEAR) if len(mean) else (0.0, 1.0)
    titles = f"{across[0]} [mm]", f"{along[0]} [mm]"
    x, y, height = equal_axes(np.array([[left, low], [right, high]]), titles, margin=0.0)
    colour = {
        "field": "value",
        "type": "quantitative",
        "title": unit,
        "scale": {"scheme": scheme, "domain": [float(least), float(most)], "clamp": True},
        "legend": {"gradientLength": 180, "format": ".3~g"},
    }
    ends = {"x2": {"field": "x2"}, "y2": {"field": "y2"}}
    said = hover(x=titles[0], y=titles[1], value=unit)
    cells = layer({"type": "rect", "clip": True}, data, tooltip=said, x=x, y=y, color=colour, **ends)
    cells["transform"] = [{"calculate": f"toNumber(datum.{one}) + {size:.6g}", "as": f"{one}2"} for one in "xy"]
    alt = f"Map of the cloud, {right - left:.3g} by {high - low:.3g} mm, coloured by {unit}."
    return chart(title, caption, alt, [cells], height=height)


def _edges(positions: tuple[Array, Array], *sides: tuple[float, float]) -> list[Array]:
    """Edges of the cells along both sides."""
    longest = max(end - start for start, end in sides)
    tried = []
    for cells in CELLS:
        size = longest / cells
        edges = [np.arange(start, end + size, size) for start, end in sides]
        tried.append((edges, size**2 * np.count_nonzero(np.histogram2d(*positions, bins=edges)[0])))
    covered = tried[-1][1]
    return next(edges for edges, area in tried if area >= FILLED * covered or edges is tried[-1][0])
