"""A scan for people: a page with its cloud from above and in space, and a few lines on the terminal."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array
from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, equal_axes, hover, layer, quantity, records
from robolaser.report.digits import measured, millimetres, plain
from robolaser.report.document import Block, Document, Figure, Figures, Notes, Section, Text, charts
from robolaser.report.scene import Scene, dots
from robolaser.report.viewer.shapes import CLEAR, by_height
from robolaser.scan import Scan
from robolaser.scan.primitives import rms_m
from robolaser.scan.quality import LEVEL, Measured, Quality

READING = (
    "A point's `std` in the cloud is its standard deviation by the calibration's noise model; errors of the calibrated"
    " model count as noise of the joints. Errors common to neighbouring points are not in the scatter; bodies of known"
    " size show them."
)
BODIES = {"plane": "plane, scatter", "step": "step, height", "sphere": "sphere, radius"}
MOST_DOTS = 15_000  # points: a page of half a megabyte, and a canvas that follows the hand
FEWEST = 10  # points that make a chart or a scene
CELLS = 110, 90, 60, 45  # along the longer side of a map; the finest that leaves no gaps between stripes
FILLED = 0.95  # of the area that the coarsest cells cover
BINS = 60


def document(scan: Scan, quality: Quality, *, brief: bool = False) -> Document:
    """The report.

    Args:
        scan: Done.
        quality: Of its cloud.
        brief: Leave out what only a page shows.
    """
    warnings = (*scan.warnings, *quality.doubts, *map(str, quality.missing))
    lines = figures(scan, quality)
    return Document(
        scan.recording.name,
        "scanned",
        heading(scan),
        lead(quality),
        "",
        [Figures(lines), Text(READING, "quiet")],
        [
            Section("Warnings", [Notes(warnings, "warnings")]),
            Section("The cloud", [] if brief else _evidence(quality, scan.cloud.counts.points)),
        ],
    )


def _evidence(quality: Quality, points: int) -> list[Block]:
    scene, shown = cloud_scene(quality), charts([make(quality) for make in CHARTS])
    used = f"{len(quality.vertices)} of {points} points, evenly taken, were used for these figures."
    left_out = [Text(used, "quiet")] if len(quality.vertices) < points else []
    return [*([scene] if scene else []), *shown, *left_out]


def lead(quality: Quality) -> str:
    """How far noise moves the points."""
    if quality.scatter_m != quality.scatter_m:  # NaN
        return "The noise of the points is not known."
    return f"Noise moves half of the points by less than {millimetres(quality.scatter_m)}."


def heading(scan: Scan) -> str:
    """What was scanned with what."""
    counts, source = scan.cloud.counts, scan.cloud.what
    return f"{counts.points} points from {source} of {counts.poses} poses, {scan.calibrated.origin}"


def figures(scan: Scan, quality: Quality) -> list[Figure]:
    """Scatter, error of the calibration, and the bodies that were measured."""
    counts = scan.cloud.counts
    known = quality.scatter_m == quality.scatter_m  # not NaN
    scatter = f"of a point by its noise, median; {LEVEL:.0%} are below {millimetres(quality.most_m)}"
    unknown = "neither stripes nor calibration state the noise of the line centres"
    size = millimetres(quality.scatter_m if known else None)
    shown = [Figure("held-out", "scatter", size, scatter if known else unknown)]
    if scan.calibrated.rms_m is not None:
        error = "error of the calibrated scanner, shared by neighbours"
        shown.append(Figure("", "calibration", millimetres(scan.calibrated.rms_m), error))
    shown += [Figure("", BODIES[body.what], _size(body), _remark(body)) for body in quality.primitives]
    if left := counts.centres - counts.points:
        why = "no point of the laser plane in front of the camera"
        shown.append(Figure("", "left out", f"{left}", f"of {counts.centres} line centres: {why}"))
    return shown


def _size(body: Measured) -> str:
    if body.size_m is None:
        return millimetres(body.rms_m)
    return measured(body.size_m, body.std_m or 0.0, "m")


def _remark(body: Measured) -> str:
    predicted = (
        f"predicted {millimetres(body.predicted_m)}" if body.predicted_m == body.predicted_m else "none predicted"
    )
    if body.error_m is None or body.known_m is None:
        return f"root mean square; {predicted}; {body.points} of the points used"
    off, _, _ = measured(abs(body.error_m), body.std_m or 0.0, "m").partition(" ±")
    sign = "+" if body.error_m >= 0 else "−"
    error = f"known {plain(body.known_m, 'm')}: off by {sign}{off} mm"
    return f"{error}; scatter {millimetres(body.rms_m)}, {predicted}; {body.points} points"


def cloud_scene(quality: Quality) -> Scene | None:
    """Points of the cloud, evenly taken; None where there are too few to see a shape."""
    positions = quality.positions[:: max(1, -(-len(quality.positions) // MOST_DOTS))]
    if len(positions) < FEWEST:
        return None
    low, high = np.percentile(positions, CLEAR, axis=0)
    thin = int(np.argmin(high - low))
    rgb = by_height(positions[:, thin], low[thin], high[thin])
    colours = [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in rgb.tolist()]
    size = 1e3 * (high - low)
    return Scene(
        "The cloud in space",
        f"Coloured along {'xyz'[thin]}, from {1e3 * low[thin]:.4g} to {1e3 * high[thin]:.4g} mm.",
        f"A cloud of {len(positions)} points, {size[0]:.3g} by {size[1]:.3g} by {size[2]:.3g} mm.",
        [dots(positions, colours, size=2.0)],
    )


def heights(quality: Quality) -> Chart | None:
    """The cloud seen along the direction in which it is thinnest, coloured by how far it stands out."""
    if len(quality.vertices) < FEWEST:
        return None
    across, along, out, what = _view(quality)
    caption = (
        f"Each cell is the mean of the points in it, {what}. Steps between neighbouring stripes, or copies of one edge,"
        " mean that the calibration does not fit this recording."
    )
    return _map("Heights", caption, across, along, 1e3 * out, "height [mm]")


def scatter(quality: Quality) -> Chart | None:
    """The same view, coloured by the scatter of its points."""
    std = quality.vertices["std"].astype(np.float64)
    if len(std) < FEWEST or not np.isfinite(std).all():
        return None
    across, along, _, _ = _view(quality)
    caption = (
        "Standard deviation of a point: the noise of its line centre, propagated through ray and laser plane, and that"
        " of the joints, through the arm. It grows where rays meet the laser plane at a shallow angle. Errors that the"
        " calibrated model does not explain count as noise of the joints; errors common to all points are not included."
    )
    return _map("Scatter of the points", caption, across, along, 1e3 * std, "std [mm]")


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
        "Distances of the points from the largest plane. Wider than predicted: the stripes do not agree with each"
        " other, and the calibration contributes; narrower: the surface is nearly parallel to the error, or errors of"
        " the calibrated model were counted as noise.",
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
    title: str, caption: str, across: tuple[str, Array], along: tuple[str, Array], value: Array, unit: str
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
        "scale": {"scheme": "viridis", "domain": [float(least), float(most)], "clamp": True},
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
