"""Which poses erred before the effects were in the model, and which still do."""

import numpy as np

from robolaser.calibration.result import rms
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    NOISE,
    Chart,
    chart,
    colours,
    hover,
    layer,
    quantity,
    records,
    rule,
)

FEW = 80  # poses up to which dots are large


def poses(diagnosis: Diagnosis) -> Chart:
    """Root-mean-square error of each pose on held-out data, before and after, in the order of the run."""
    dataset = diagnosis.observed
    seen = np.unique(dataset.points.pose)
    time = dataset.poses.time_s
    seen = seen if time is None else seen[np.argsort(time[seen], kind="stable")]
    both = {"before": diagnosis.before_m, "after": diagnosis.after_m}
    after = "after" if diagnosis.model.effects else "each pose"
    errors = {after: both["after"]} | ({"before": both["before"]} if diagnosis.model.effects else {})
    of = {"before": HELD_OUT, after: FITTED, "noise alone": NOISE}
    names = [dataset.poses.names[i] for i in seen]
    data = {
        series: records(
            number=np.arange(1, len(seen) + 1),
            pose=names,
            rms=[1e3 * rms(whose[dataset.points.pose == i]) for i in seen],
            series=series,
        )
        for series, whose in errors.items()
    }
    floor = records(rms=1e3 * diagnosis.gap.noise_floor_m, series="noise alone")
    title = "pose, in the order of " + ("poses.csv" if time is None else "the run")
    x, y = quantity("number", title, domain=(0, len(seen) + 1)), quantity("rms", "held-out RMS error [mm]", log=True)
    colour = colours({name: of[name] for name in of if name in (*errors, "noise alone")})
    dots = {"type": "point", "size": 46 if len(seen) <= FEW else 18}
    rings = dots | {"filled": False, "strokeWidth": 1.4}
    said = hover("pose", "series", rms="held-out RMS error [mm]")
    ranked = sorted(data[after], key=lambda row: -(row["rms"] or 0.0))
    largest = [row["pose"] for row in ranked[:3]]
    return chart(
        "Errors of each pose",
        "Each pose predicted by fits that did not see it. A slope or a step along the run indicates something that"
        f" changed meanwhile. Largest now: {', '.join(largest)}.",
        f"Errors of {len(seen)} poses before and after; the largest now is that of {largest[0]}.",
        [
            layer(dots, data[after], tooltip=said, x=x, y=y, color=colour),
            layer(rings, data.get("before", []), tooltip=said, x=x, y=y, color=colour),
            layer(rule(), floor, tooltip=hover("series", rms="RMS error [mm]"), y=y, color=colour),
        ],
    )  # fmt: skip
