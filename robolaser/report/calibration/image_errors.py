"""The chart of errors over the image."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.report.cell_poses import CellPoses
from robolaser.report.chart import MUTED, Chart, chart, equal_axes, hover, layer, records
from robolaser.report.error_analysis import ErrorAnalysis, lengths_mm, point_names, some_rows
from robolaser.report.scene import magnification

MOST_DOTS = 600  # points that a chart carries
DIVERGING = ("#2f6fbb", "#a9b1b9", "#cf4a2e")
"""From nearer than known to farther; visible on light and dark paper."""


def image_errors(analysis: ErrorAnalysis) -> Chart | None:
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
    error = {"error": "error [mm]"} | ({} if depth_mm is None else {"depth": "error along the view [mm]"})
    data = records(
        pose=pose, point=point, x=pixel[rows, 0], y=pixel[rows, 1], x2=end[rows, 0], y2=end[rows, 1],
        error=errors_mm[rows], **({} if depth_mm is None else {"depth": depth_mm[rows]}),
    )  # fmt: skip
    corners = np.array([[-0.5, -0.5], [width - 0.5, height - 0.5]])
    x, y, tall = equal_axes(corners, ("u [px]", "v [px]"), margin=0.01)
    y["scale"]["reverse"] = True
    frame = records(x=-0.5, y=-0.5, x2=width - 0.5, y2=height - 0.5)
    ends = {"x": x, "y": y, "x2": {"field": "x2"}, "y2": {"field": "y2"}}
    dots = {"type": "point", "size": 22, "opacity": 1}
    in_space = depth_mm is not None
    colour = {"value": MUTED} if depth_mm is None else _colour(depth_mm)
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
            layer(dots, data, tooltip=hover("pose", "point", **error), x=x, y=y, color=colour),
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
