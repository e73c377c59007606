"""Where the points are and where the model puts them: the paper's Figure 6."""

import numpy as np

from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, equal_axes, hover, layer
from robolaser.report.digits import plain
from robolaser.report.error_analysis import ErrorAnalysis, some_rows
from robolaser.report.magnification import magnification

MOST = 600  # arrows that a chart carries


def points(analysis: ErrorAnalysis) -> Chart | None:
    """Known points and the errors of the estimated ones, magnified, along the direction in which they spread least."""
    sensor, known, errors = analysis.calibration.model.sensor, analysis.known, -analysis.fitted_m
    if known is None:
        return None
    extent = np.ptp(known, axis=0)
    along = int(np.argmin(extent))
    across = [axis for axis in range(3) if axis != along]
    rows = some_rows(analysis.fitted_mm, MOST)
    factor = magnification(float(np.percentile(analysis.fitted_mm, 95)) / 1e3, float(extent[across].max()))
    start = 1e3 * known[rows][:, across]
    end = start + 1e3 * factor * errors[rows][:, across]
    x, y, height = equal_axes(np.concatenate([start, end]), tuple(f"{'xyz'[axis]} [mm]" for axis in across))
    times = plain(factor, "")
    what, error = sensor.row_point, f"error × {times}"
    data = analysis.named(
        rows, x=start[:, 0], y=start[:, 1], x2=end[:, 0], y2=end[:, 1], error=analysis.fitted_mm[rows]
    )
    colour = colours({what: FITTED, error: HELD_OUT})
    said = hover("pose", "point", error="error [mm]")
    left_out = len(rows) < len(known)
    thinned = f" {len(rows)} of {len(known)} points are drawn, the largest errors among them." if left_out else ""
    return chart(
        "Known and estimated points",
        f"Seen along {'xyz'[along]} of the {sensor.frame}; a line leads from each {what} to the estimated one, its"
        f" length magnified {times} times. Neighbouring errors that are alike indicate something"
        f" unmodelled; noise points in any direction.{thinned}",
        f"Plan of the points with error lines magnified {times} times.",
        [
            layer("rule", _series(data, error), tooltip=said, x=x, y=y, x2={"field": "x2"}, y2={"field": "y2"},
                  color=colour),
            layer({"type": "point", "size": 18, "opacity": 1}, _series(data, what), tooltip=said, x=x, y=y,
                  color=colour),
        ],
        height=height,
    )  # fmt: skip


def _series(data: list[dict[str, object]], name: str) -> list[dict[str, object]]:
    return [row | {"series": name} for row in data]
