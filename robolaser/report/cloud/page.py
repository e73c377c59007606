"""A scan for people: a page, and a few lines on the terminal."""

import numpy as np

from robolaser.report.cloud.charts import CHARTS
from robolaser.report.digits import measured, millimetres, plain
from robolaser.report.document import Block, Document, Figure, Figures, Notes, Section, Text, charts
from robolaser.report.scene import Scene, dots
from robolaser.report.viewer.downsampling import CLEAR, by_height
from robolaser.scan import Scan
from robolaser.scan.quality import LEVEL, Measured, Quality

READING = (
    "A point's `std` in the cloud is how far noise moves it, by the calibration's noise model; what that model did not"
    " explain counts as noise of the joints. Errors that neighbours share do not show in the scatter, but they do on"
    " bodies of known size."
)


def document(scan: Scan, quality: Quality, *, command: str = "", brief: bool = False) -> Document:
    """The report.

    Args:
        scan: Done.
        quality: Of its cloud.
        command: What to type to repeat it.
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
            Section("Warnings", [Notes(warnings, "warnings")] if warnings else []),
            Section("The cloud", [] if brief else _evidence(quality, scan.cloud.counts.points)),
        ],
        command=command,
    )


def _evidence(quality: Quality, points: int) -> list[Block]:
    scene, shown = cloud_scene(quality), charts([make(quality) for make in CHARTS])
    used = f"{len(quality.vertices)} of {points} points, evenly taken, were used for these figures."
    left_out = [Text(used, "quiet")] if len(quality.vertices) < points else []
    return [*([scene] if scene else []), *shown, *left_out]


def lead(quality: Quality) -> str:
    """How far noise moves the points."""
    if quality.scatter_m != quality.scatter_m:  # NaN
        return "How far noise moves the points is not known."
    return f"Noise moves half of the points by less than {millimetres(quality.scatter_m)}."


BODIES = {"plane": "plane, scatter", "step": "step, height", "sphere": "sphere, radius"}


def heading(scan: Scan) -> str:
    """What was scanned with what."""
    counts, source = scan.cloud.counts, scan.cloud.what
    return f"{counts.points} points from {source} of {counts.poses} poses, {scan.calibrated.origin}"


def figures(scan: Scan, quality: Quality) -> list[Figure]:
    """Scatter, error of the calibration, and the bodies that were measured."""
    counts = scan.cloud.counts
    known = quality.scatter_m == quality.scatter_m  # not NaN
    scatter = f"of a point by its noise, median; {LEVEL:.0%} are below {millimetres(quality.most_m)}"
    unknown = "neither stripes nor calibration say how noisy the line centres are"
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


MOST = 15_000  # points: a page of half a megabyte, and a canvas that follows the hand
FEWEST = 10


def cloud_scene(quality: Quality) -> Scene | None:
    """Points of the cloud, evenly taken; None where there are too few to see a shape."""
    positions = quality.positions[:: max(1, -(-len(quality.positions) // MOST))]
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
