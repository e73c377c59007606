"""Errors at the points, before and after, on the same scale."""

import numpy as np

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import FITTED, HELD_OUT, INK, Chart, chart, colours, equal_axes, hover, layer, records
from robolaser.report.digits import plain
from robolaser.report.error_analysis import known_points, lengths_mm, point_names, some_rows
from robolaser.report.magnification import magnification

MOST = 400  # arrows of each kind


def plans(diagnosis: Diagnosis) -> Chart | None:
    """A plan of the points with magnified errors: in the calibrated model, and with all effects in it."""
    model, known = diagnosis.model, known_points(diagnosis.model, diagnosis.x)
    if known is None or diagnosis.after_m.shape[1] != 3:
        return None
    known = 1e3 * known
    extent = np.ptp(known, axis=0)
    along = int(np.argmin(extent))
    across = [axis for axis in range(3) if axis != along]
    both = {"before": diagnosis.before_m, "after": diagnosis.after_m}
    shown = both if diagnosis.model.effects else {"now": diagnosis.after_m}
    lengths = lengths_mm(next(iter(shown.values())))
    rows = some_rows(lengths, MOST)
    factor = magnification(float(np.percentile(lengths, 95)), float(extent[across].max()))
    start = known[rows][:, across]
    ends = {name: start - 1e3 * factor * errors[rows][:, across] for name, errors in shown.items()}
    x, y, height = equal_axes(np.concatenate([start, *ends.values()]), tuple(f"{'xyz'[a]} [mm]" for a in across))
    pose, point = point_names(model.dataset, rows)
    arrows = [
        row
        for name, end in ends.items()
        for row in records(x=start[:, 0], y=start[:, 1], x2=end[:, 0], y2=end[:, 1], pose=pose, point=point,
                           error=lengths_mm(shown[name][rows]), series=name)
    ]  # fmt: skip
    colour = colours({name: HELD_OUT if name == "before" else FITTED for name in shown})
    dots = records(x=start[:, 0], y=start[:, 1], pose=pose, point=point)
    sensor, times = model.sensor, plain(factor, "")
    when = "before and after the effects were added" if diagnosis.model.effects else "as the model leaves them"
    return chart(
        "Errors before and after" if diagnosis.model.effects else "Errors at the points",
        f"Seen along {'xyz'[along]} of the {sensor.frame}: a line leads from each {sensor.row_point} to where it is"
        f" predicted from other poses, {when}; all are magnified {times} times. What is left should"
        " point in any direction.",
        f"Plan of the points with error lines magnified {times} times.",
        [
            layer({"type": "rule", "strokeWidth": 1.2}, arrows, tooltip=hover("pose", "point", "series",
                  error="error [mm]"), x=x, y=y, x2={"field": "x2"}, y2={"field": "y2"}, color=colour),
            layer({"type": "point", "size": 9, "color": INK, "opacity": 0.6}, dots, tooltip=hover("pose", "point"),
                  x=x, y=y),
        ],
        height=height,
    )  # fmt: skip
