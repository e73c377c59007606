"""How the search converged: the paper's Figure 8."""

import numpy as np

from robolaser.estimation.multistart import subsampled
from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, hover, layer, line, quantity, records, rule
from robolaser.report.digits import millimetres
from robolaser.report.error_analysis import ErrorAnalysis


def convergence(analysis: ErrorAnalysis) -> Chart | None:
    """Best error so far over the generations, and that of the result."""
    calibration, history = analysis.calibration, analysis.calibration.history
    if history is None or len(history.best) < 2:
        return None
    rows = len(subsampled(calibration.model).dataset.points)
    best_mm = 1e3 * np.sqrt(np.where(np.isfinite(history.best), history.best, np.nan) / rows)
    last = len(best_mm) - 1
    kept = np.unique([0, *(np.flatnonzero(np.diff(best_mm)) + 1), last])
    data = records(generation=kept + 1, rms=best_mm[kept], series="best candidate")
    x, y = quantity("generation", "generation", domain=(1, last + 1)), quantity("rms", "RMS error [mm]", log=True)
    colour = colours({"best candidate": FITTED, "result": HELD_OUT})
    said = hover("series", generation="generation", rms="RMS error [mm]")
    result = records(rms=1e3 * calibration.rms_m, series="result")
    before, after = millimetres(best_mm[-1] / 1e3), millimetres(calibration.rms_m)
    return chart(
        "Convergence",
        f"Best error so far in each generation of {calibration.algorithm}, and the error of the result, after local"
        " refinement unless that was switched off. If the curve is still falling at the right edge, the search stopped"
        " too early; if the result lies far below it, the refinement found what the search had missed.",
        f"The best error falls to {before} in {len(best_mm)} generations; the result has {after}.",
        [
            layer(line(step=True), data, tooltip=said, x=x, y=y, color=colour),
            layer(rule(), result, tooltip=hover("series", rms="RMS error [mm]"), y=y, color=colour),
        ],
    )
