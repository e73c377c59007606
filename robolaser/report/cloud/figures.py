"""What a scan gave, in lines of a few words and numbers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from robolaser.report.digits import measured, millimetres, plain
from robolaser.scan import Scan
from robolaser.scan.quality import LEVEL, Measured, Quality

BODIES = {"plane": "plane, scatter", "step": "step, height", "sphere": "sphere, radius"}


@final
@dataclass(frozen=True)
class ScanFigure:
    """One figure of a scan: what it is, its value with unit, and how to read it."""

    what: str
    value: str
    remark: str


def heading(scan: Scan) -> str:
    """What was scanned with what."""
    counts, source = scan.cloud.counts, scan.cloud.what
    return f"{counts.points} points from {source} of {counts.poses} poses, {scan.calibrated.origin}"


def figures(scan: Scan, quality: Quality) -> Iterator[ScanFigure]:
    """Scatter, error of the calibration, and the bodies that were measured."""
    counts = scan.cloud.counts
    known = quality.scatter_m == quality.scatter_m  # not NaN
    yield ScanFigure(
        "scatter",
        millimetres(quality.scatter_m if known else None),
        f"of a point by its noise, median; {LEVEL:.0%} are below {millimetres(quality.most_m)}"
        if known
        else "neither stripes nor calibration say how noisy the line centres are",
    )
    if scan.calibrated.rms_m is not None:
        yield ScanFigure(
            "calibration", millimetres(scan.calibrated.rms_m), "error of the calibrated scanner, shared by neighbours"
        )
    for body in quality.primitives:
        yield ScanFigure(BODIES[body.what], _size(body), _remark(body))
    left = counts.centres - counts.points
    if left:
        why = "no point of the laser plane in front of the camera"
        yield ScanFigure("left out", f"{left}", f"of {counts.centres} line centres: {why}")


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
