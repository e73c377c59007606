"""A scan for people: a page with its cloud from above and in space, and a few lines on the terminal."""

import numpy as np

from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, equal_axes, hover, layer, quantity, records
from robolaser.report.digits import measured, millimetres, plain
from robolaser.report.document import Content, Document, Figure, Figures, Notes, Section, Text, charts
from robolaser.report.scene import Scene, dots
from robolaser.report.viewer.scene import CLEAR, by_height
from robolaser.scan import Scan
from robolaser.scan.quality import LEVEL, Measured, Quality

READING = (
    "A point's `std` in the cloud is its standard deviation by the calibration's noise model; errors of the calibrated"
    " model count as noise of the joints. Errors common to neighbouring points are not in the scatter; bodies of known"
    " size show them."
)
BODIES = {"plane": "plane, scatter", "step": "step, height", "sphere": "sphere, radius"}
MOST_DOTS = 15_000  # points: a page of half a megabyte, and a responsive canvas
FEWEST = 10  # fewest points of a chart or a scene
CELLS = 60  # along the longer side of a map
BINS = 60


def document(scan: Scan, quality: Quality, *, brief: bool = False) -> Document:
    """The report on a finished scan; in brief without the parts that only a page shows."""
    counts, warnings = scan.cloud.counts, (*scan.warnings, *quality.doubts, *map(str, quality.missing))
    return Document(
        scan.recording.name,
        "scanned",
        f"{counts.points} points from {scan.cloud.what} of {counts.poses} poses, {scan.calibrated.origin}",
        "The noise of the points is not known."
        if np.isnan(quality.scatter_m)
        else f"Noise moves half of the points by less than {millimetres(quality.scatter_m)}.",
        "",
        [Figures(figures(scan, quality)), Text(READING, "quiet")],
        [
            Section("Warnings", [Notes(warnings, "warnings")]),
            Section("The cloud", [] if brief else _evidence(quality, counts.points)),
        ],
    )


def _evidence(quality: Quality, points: int) -> list[Content]:
    scene, shown = cloud_scene(quality), charts([heights(quality), off_plane(quality)])
    used = f"{len(quality.vertices)} of {points} points, evenly taken, were used for these figures."
    left_out = [Text(used, "quiet")] if len(quality.vertices) < points else []
    return [*([scene] if scene else []), *shown, *left_out]


def figures(scan: Scan, quality: Quality) -> list[Figure]:
    """Scatter, error of the calibration, and the measured bodies."""
    counts, known = scan.cloud.counts, not np.isnan(quality.scatter_m)
    scatter = f"of a point by its noise, median; {LEVEL:.0%} are below {millimetres(quality.most_m)}"
    unknown = "neither stripes nor calibration state the noise of the line centres"
    size = millimetres(quality.scatter_m if known else None)
    shown = [Figure("held-out", "scatter", size, scatter if known else unknown)]
    if scan.calibrated.rms_m is not None:
        error = "error of the calibrated scanner, shared by neighbours"
        shown.append(Figure("", "calibration", millimetres(scan.calibrated.rms_m), error))
    for body in quality.primitives:
        size = millimetres(body.rms_m) if body.size_m is None else measured(body.size_m, body.std_m or 0.0, "m")
        shown.append(Figure("", BODIES[body.what], size, _remark(body)))
    if left := counts.centres - counts.points:
        why = "no point of the laser plane in front of the camera"
        shown.append(Figure("", "left out", f"{left}", f"of {counts.centres} line centres: {why}"))
    return shown


def _remark(body: Measured) -> str:
    predicted = "none predicted" if np.isnan(body.predicted_m) else f"predicted {millimetres(body.predicted_m)}"
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
    """The cloud seen along the direction in which it is thinnest, coloured by height."""
    if len(quality.vertices) < FEWEST:
        return None
    places = 1e3 * quality.positions
    low, high = np.percentile(places, CLEAR, axis=0)
    thin = int(np.argmin(high - low))
    out, what = places[:, thin], f"by its {'xyz'[thin]} in the base frame"
    if quality.plane is not None:
        out, what = 1e3 * quality.plane.distance, "above the largest plane"
    seen = [axis for axis in range(3) if axis != thin]
    longest = float((high - low)[seen].max())
    margin = 0.03 * longest or 1.0
    ends = np.stack([low[seen] - margin, high[seen] + margin])
    size = (longest + 2 * margin) / CELLS
    edges = [np.arange(start, end + size, size) for start, end in ends.T]
    across, along = places[:, seen].T
    count, total = (np.histogram2d(across, along, bins=edges, weights=each)[0] for each in (None, out))
    i, j = np.nonzero(count)
    mean = total[i, j] / count[i, j]
    rows = zip(edges[0][i], edges[1][j], mean, strict=True)
    data = "x,y,value\n" + "".join(f"{a:.5g},{b:.5g},{c:.4g}\n" for a, b, c in rows)
    titles = [f"{'xyz'[axis]} [mm]" for axis in seen]
    x, y, height = equal_axes(ends, titles, margin=0.0)
    colour = {
        "field": "value",
        "type": "quantitative",
        "title": "height [mm]",
        "scale": {"scheme": "viridis", "domain": np.percentile(mean, CLEAR).tolist(), "clamp": True},
        "legend": {"gradientLength": 180, "format": ".3~g"},
    }
    tooltip = hover(x=titles[0], y=titles[1], value="height [mm]")
    beyond = {"x2": {"field": "x2"}, "y2": {"field": "y2"}}
    cells = layer({"type": "rect", "clip": True}, data, tooltip=tooltip, x=x, y=y, color=colour, **beyond)
    cells["transform"] = [{"calculate": f"toNumber(datum.{one}) + {size:.6g}", "as": f"{one}2"} for one in "xy"]
    return chart(
        "Heights",
        f"Each cell is the mean of the points in it, {what}. Steps between neighbouring stripes, or copies of one edge,"
        " mean that the calibration does not fit this recording.",
        f"Map of the cloud, {ends[1, 0] - ends[0, 0]:.3g} by {ends[1, 1] - ends[0, 1]:.3g} mm, coloured by height.",
        [cells],
        height=height,
    )


def off_plane(quality: Quality) -> Chart | None:
    """Distances of points from their plane, against those that their scatter predicts."""
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
    tooltip = hover("series", distance="distance [mm]", share="share of the points [%]")
    bars = {"type": "rect", "opacity": 0.6}
    found = records(distance=edges[:-1], to=edges[1:], share=share, series=measured)
    layers = [layer(bars, found, tooltip=tooltip, x=x, x2={"field": "to"}, y=y, y2={"datum": 0}, color=colour)]
    if np.isfinite(std).all() and (std > 0).all():
        some = std[:: max(1, len(std) // 2000), None]
        normal = (np.exp(-0.5 * (centres / some) ** 2) / (np.sqrt(2 * np.pi) * some)).mean(axis=0)
        curve = records(distance=centres, share=100 * width * normal, series=predicted)
        layers.append(layer({"type": "line", "clip": True}, curve, tooltip=tooltip, x=x, y=y, color=colour))
    return chart(
        "Points about the largest plane",
        "Distances of the points from the largest plane. Wider than predicted: the stripes do not agree with each"
        " other, and the calibration contributes; narrower: the surface is nearly parallel to the error, or errors of"
        " the calibrated model were counted as noise.",
        f"Histogram of {int(plane.on.sum())} distances from a plane, root mean square {1e3 * plane.rms_m:.3g} mm.",
        layers,
    )
