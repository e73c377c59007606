"""A calibration in charts: how the search went, where in the image errors are, and whether they look like noise."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.estimation.multistart import subsampled
from robolaser.report.cell_poses import CellPoses
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    MUTED,
    NOISE,
    Chart,
    chart,
    colours,
    equal_axes,
    hover,
    layer,
    line,
    quantity,
    records,
    rule,
)
from robolaser.report.digits import millimetres
from robolaser.report.error_analysis import ErrorAnalysis, lengths_mm, point_names, some_rows
from robolaser.report.scene import magnification


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
        " too early; if the result is far below it, the refinement found what the search had missed.",
        f"The best error falls to {before} in {len(best_mm)} generations; the result has {after}.",
        [
            layer(line(step=True), data, tooltip=said, x=x, y=y, color=colour),
            layer(rule(), result, tooltip=hover("series", rms="RMS error [mm]"), y=y, color=colour),
        ],
    )


MOST_DOTS = 600  # points that a chart carries
DIVERGING = ("#2f6fbb", "#a9b1b9", "#cf4a2e")
"""From nearer than known to farther; visible on light and dark paper."""


def image(analysis: ErrorAnalysis) -> Chart | None:
    """Errors over the pixel plane: lines across the view, colour along it where a row places a point in space."""
    calibration = analysis.calibration
    dataset, pixel = calibration.model.dataset, calibration.model.dataset.points.pixel
    cell = CellPoses(calibration.model, calibration.x)
    misses, errors_mm = cell.misses(calibration.errors_m), lengths_mm(calibration.errors_m)
    if misses is None or pixel is None or dataset.image_px is None:
        return None
    width, height = dataset.image_px
    depth_mm = _along_view(analysis, cell)
    rows = some_rows(errors_mm, MOST_DOTS)
    pose, point = point_names(dataset, rows)
    factor = magnification(float(np.percentile(np.linalg.norm(misses, axis=-1), 95)), float(width))
    end = pixel + factor * misses
    data = records(
        pose=pose, point=point, x=pixel[rows, 0], y=pixel[rows, 1], x2=end[rows, 0], y2=end[rows, 1],
        error=errors_mm[rows],
        **({} if depth_mm is None else {"depth": depth_mm[rows]}),
    )  # fmt: skip
    corners = np.array([[-0.5, -0.5], [width - 0.5, height - 0.5]])
    x, y, tall = equal_axes(corners, ("u [px]", "v [px]"), margin=0.01)
    y["scale"]["reverse"] = True
    frame = records(x=-0.5, y=-0.5, x2=width - 0.5, y2=height - 0.5)
    ends = {"x": x, "y": y, "x2": {"field": "x2"}, "y2": {"field": "y2"}}
    dots = {"type": "point", "size": 22, "opacity": 1}
    in_space = depth_mm is not None
    if depth_mm is not None:
        said = hover("pose", "point", error="error [mm]", depth="along the view [mm]")
        coloured = layer(dots, data, tooltip=said, x=x, y=y, color=_colour(depth_mm))
    else:
        coloured = layer({**dots, "color": MUTED}, data, tooltip=hover("pose", "point", error="error [mm]"), x=x, y=y)
    seen = "the stripe" if in_space else "the target"
    of_colour = "its colour is the error along the view (red: estimated too far away), " if in_space else ""
    return chart(
        "Errors over the image",
        f"Each dot is a pixel of {seen}: {of_colour}its line leads to where the model predicts it, {factor:.3g} times"
        " as long."
        f" {'Colours or lines' if in_space else 'Lines'} that change slowly over the image indicate the lens"
        f"{' or the laser plane' if in_space else ''}; a random mixture is noise.",
        f"The image of {width} × {height} pixels with dots where {seen} was seen.",
        [
            coloured,
            layer({"type": "rule", "color": MUTED, "strokeWidth": 0.8}, data, **ends),
            layer({"type": "rect", "filled": False, "stroke": MUTED, "strokeWidth": 0.7}, frame, **ends),
        ],
        height=tall,
    )


def _colour(depth_mm: Array) -> dict[str, Any]:
    limit = float(np.percentile(np.abs(depth_mm), 98)) or 1.0
    return {
        "field": "depth",
        "type": "quantitative",
        "title": "error along the view [mm]",
        "scale": {"domain": [-limit, 0, limit], "range": DIVERGING, "clamp": True},
        "legend": {"gradientLength": 180, "format": ".2~g"},
    }


def _along_view(analysis: ErrorAnalysis, cell: CellPoses) -> Array | None:
    """Errors of estimates along the view, (m,) [mm]; 0 for rows that say nothing of it, None if all are such."""
    across = cell.across_view(analysis.calibration.errors_m)
    if cell.camera is None or across.all():
        return None
    along = np.einsum(
        "mj,mj->m", cell.camera[analysis.calibration.model.dataset.points.pose, :3, 2], analysis.calibration.errors_m
    )
    return np.where(across, 0.0, -1e3 * along)


BINS = 40
DRAWN = 40_000  # errors of noise, for a smooth curve


def distribution(analysis: ErrorAnalysis) -> Chart | None:
    """Lengths of the errors beside those that known noise would make."""
    fitted, held_out = analysis.calibration.errors_m, analysis.calibration.held_out
    errors = {"fitted": lengths_mm(fitted)} | ({} if held_out is None else {"held out": lengths_mm(held_out)})
    noise = analysis.drawn_noise_mm(max(1, DRAWN // len(fitted)), np.random.default_rng(0))
    errors = errors if noise is None else {"noise alone": noise} | errors
    everything = np.concatenate(list(errors.values()))
    everything = everything[everything > 0]
    if not len(everything):
        return None
    low, high = np.percentile(everything, 0.5), everything.max()
    edges = np.geomspace(max(low, high * 1e-6) * 0.8, high * 1.25, BINS)
    bins = {name: _bins(part, edges, name) for name, part in errors.items()}
    x = quantity("from", "error of a point [mm]", log=True, domain=(edges[0], edges[-1]))
    encoding = {
        "x": x,
        "y": quantity("share", "share of the points [%]") | {"stack": None},
        "color": colours({name: {"noise alone": NOISE, "fitted": FITTED, "held out": HELD_OUT}[name] for name in bins}),
    }
    said = hover("series", **{"from": "from [mm]", "to": "to [mm]", "share": "share of the points [%]"})
    layers = []
    if "noise alone" in bins:
        area = {"type": "area", "interpolate": "step-after", "opacity": 0.35, "clip": True}
        layers.append(layer(area, bins["noise alone"], **encoding))
    lines = [row for name in bins for row in bins[name]]
    reading = (
        "Grey: what the known noise alone would make of points like these. If the curves extend beyond it to the"
        " right, there is another source of error; a small separate peak is a few gross errors."
        if "noise alone" in bins
        else "No noise is known to compare with. One smooth peak is a good sign; a small separate one is a few gross"
        " errors."
    )
    return chart(
        "Errors against noise",
        f"How large the errors of single points are. {reading}",
        "Histograms of the error lengths, fitted and held out, beside those of noise.",
        [*layers, layer(line(step=True, strokeWidth=1.6), lines, tooltip=said, **encoding)],
    )


def _bins(errors: Array, edges: Array, name: str) -> list[dict[str, float]]:
    share = np.histogram(errors, edges)[0] / len(errors) * 100
    return records(**{"from": edges, "to": np.append(edges[1:], np.nan), "share": np.append(share, 0), "series": name})
