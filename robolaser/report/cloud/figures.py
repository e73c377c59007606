"""What a scan gave, in lines of a few words and numbers."""

from robolaser.report.digits import measured, millimetres, plain
from robolaser.report.document import Figure
from robolaser.scan import Scan
from robolaser.scan.quality import LEVEL, Measured, Quality

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
