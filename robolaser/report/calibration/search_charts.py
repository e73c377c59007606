"""How the search went: the paper's Figures 7 and 8."""

import numpy as np

from robolaser.estimation.multistart import subsampled
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    LINES,
    Chart,
    chart,
    colours,
    hover,
    layer,
    line,
    quantity,
    records,
    rule,
)
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


MOST = 16  # lines that an eye can follow
MOMENTS = 150  # generations that a line is drawn through


def parameters(analysis: ErrorAnalysis) -> Chart | None:
    """Each parameter of the best candidate, scaled to its bounds, over the generations."""
    calibration, history = analysis.calibration, analysis.calibration.history
    if history is None or len(history.best) < 2:
        return None
    names = history.names[:MOST]
    model = calibration.model.parameters
    columns = model.columns(names)
    scaled = (history.x[:, : len(names)] - model.lower[columns]) / model.width[columns]
    final = (calibration.x[columns] - model.lower[columns]) / model.width[columns]
    last = len(scaled) - 1
    changes = np.flatnonzero(np.any(np.diff(scaled, axis=0, prepend=np.nan) != 0, axis=1))
    some = changes[np.linspace(0, len(changes) - 1, min(MOMENTS, len(changes))).astype(int)]
    shown = np.unique([0, *some, last])
    data = [
        row
        for i, name in enumerate(names)
        for row in records(generation=shown + 1, place=scaled[shown, i], series=name)
    ]
    ends = records(generation=last + 1, place=final, series=list(names))
    y = quantity("place", None, domain=(-0.02, 1.02))
    y["axis"] = {
        "values": [0, 0.5, 1],
        "labelExpr": "datum.value == 0 ? 'lower bound' : datum.value == 1 ? 'upper bound' : datum.label",
    }
    colour = colours(
        {name: LINES[i % len(LINES)] for i, name in enumerate(names)}, legend={"columns": 4, "symbolType": "stroke"}
    )
    dash = {
        "field": "series",
        "type": "nominal",
        "title": None,
        "scale": {"domain": list(names), "range": [[1, 0] if i < len(LINES) else [4, 2] for i in range(len(names))]},
    }
    encoding = {"x": quantity("generation", "generation", domain=(1, last + 1)), "y": y, "color": colour}
    said = hover("series", generation="generation", place="share of the way from lower to upper bound")
    return chart(
        "Parameters over the generations",
        "The best candidate's parameters, scaled to their bounds; the dots at the right are the final values. Lines"
        " that keep moving while the error no longer falls belong to parameters that these data hardly determine; a"
        " dot at 0 or 1 belongs to a parameter that presses against its bound.",
        f"Lines for {', '.join(names)} between lower bound 0 and upper bound 1.",
        [
            layer(line(step=True, strokeWidth=1.3), data, tooltip=said, strokeDash=dash, **encoding),
            layer({"type": "point", "size": 40, "opacity": 1, "clip": False}, ends, tooltip=said, **encoding),
        ],
    )
