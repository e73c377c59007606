"""Which poses err."""

import numpy as np

from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, hover, layer, quantity, records
from robolaser.report.error_analysis import ErrorAnalysis

STRIPS = 80  # poses up to which each point is drawn too
NAMED = 12  # poses up to which their names find room below the axis


def poses(analysis: ErrorAnalysis) -> Chart | None:
    """Root-mean-square error of each pose, fitted and held out."""
    calibration = analysis.calibration
    points, names = calibration.model.dataset.points, calibration.model.dataset.poses.names
    seen, fitted = analysis.per_pose(analysis.fitted_m)
    held_out = None if analysis.held_out_m is None else analysis.per_pose(analysis.held_out_m)[1]
    called = [names[i] for i in seen]
    number = np.arange(1, len(seen) + 1)
    of = {"fitted": FITTED} | ({} if held_out is None else {"held out": HELD_OUT})
    which = {"number": number, "pose": called}
    others = [] if held_out is None else records(rms=held_out, series="held out", **which)
    x = (
        {"field": "pose", "type": "ordinal", "sort": None, "title": "pose", "axis": {"labelAngle": -35}}
        if len(seen) <= NAMED
        else quantity("number", "pose, in the order of poses.csv", domain=(0, len(seen) + 1))
    )
    y = quantity("rms", "RMS error [mm]", log=True)
    size = 46 if len(seen) <= STRIPS else 18
    said = hover("pose", "series", rms="RMS error [mm]")
    encoding = {"tooltip": said, "x": x, "y": y, "color": colours(of)}
    layers = [
        layer({"type": "point", "size": size}, records(rms=fitted, series="fitted", **which), **encoding),
        layer({"type": "point", "size": size, "filled": False, "strokeWidth": 1.4}, others, **encoding),
    ]
    if len(seen) <= STRIPS:
        own = analysis.named(np.arange(len(points)), number=number[np.searchsorted(seen, points.pose)],
                             rms=np.maximum(analysis.fitted_mm, 1e-6), series="fitted")  # fmt: skip
        tick = {"type": "tick", "thickness": 1, "size": 7, "orient": "horizontal", "opacity": 0.35}
        said = hover("pose", "point", rms="error [mm]")
        layers.append(layer(tick, own, tooltip=said, x=x, y=y, color=colours(of)))
    worst = called[int(np.argmax(fitted if held_out is None else held_out))]
    return chart(
        "Errors of each pose",
        "Dots: root-mean-square error of a pose when it was fitted (blue) and when it was held out (orange)"
        f"{'; ticks: its points' if len(seen) <= STRIPS else ''}. A single high pose calls for a look at what was"
        " measured there, a step or a slope along the run for what changed meanwhile."
        f" Worst: pose {worst}.",
        f"Errors of {len(seen)} poses; the worst is {worst}.",
        layers,
        zoomable=len(seen) > NAMED,
    )
