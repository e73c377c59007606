"""Where in the image the errors are."""

import numpy as np

from robolaser.arrays import Array
from robolaser.report.calibration.charts.points import magnification
from robolaser.report.calibration.error_analysis import ErrorAnalysis, some_rows
from robolaser.report.chart import MUTED, Chart, chart, equal_axes, hover, layer, records

MOST = 600  # points that a chart carries
DIVERGING = ("#2f6fbb", "#a9b1b9", "#cf4a2e")
"""From nearer than known to farther; visible on light and dark paper."""


def image(analysis: ErrorAnalysis) -> Chart | None:
    """Errors over the pixel plane: lines across the view, colour along it. For cameras on the flange."""
    dataset = analysis.calibration.model.dataset
    mount = analysis.calibration.model.sensor.mount(analysis.values, analysis.perturb)
    pixel = dataset.points.pixel
    if mount is None or pixel is None or dataset.image_px is None:
        return None
    width, height = dataset.image_px
    across_mm, depth_mm = _in_view(analysis, mount)
    rows = some_rows(analysis.fitted_mm, MOST)
    factor = magnification(float(np.percentile(np.linalg.norm(across_mm, axis=-1), 95)), float(width))
    limit = float(np.percentile(np.abs(depth_mm), 98)) or 1.0
    end = pixel + factor * across_mm
    data = analysis.named(
        rows, x=pixel[rows, 0], y=pixel[rows, 1], x2=end[rows, 0], y2=end[rows, 1],
        depth=depth_mm[rows], error=analysis.fitted_mm[rows],
    )  # fmt: skip
    corners = np.array([[-0.5, -0.5], [width - 0.5, height - 0.5]])
    x, y, tall = equal_axes(corners, ("u [px]", "v [px]"), margin=0.01)
    y["scale"]["reverse"] = True
    frame = records(x=-0.5, y=-0.5, x2=width - 0.5, y2=height - 0.5)
    ends = {"x": x, "y": y, "x2": {"field": "x2"}, "y2": {"field": "y2"}}
    colour = {
        "field": "depth",
        "type": "quantitative",
        "title": "error along the view [mm]",
        "scale": {"domain": [-limit, 0, limit], "range": DIVERGING, "clamp": True},
        "legend": {"gradientLength": 180, "format": ".2~g"},
    }
    said = hover("pose", "point", error="error [mm]", depth="along the view [mm]")
    return chart(
        "Errors over the image",
        f"Each dot is a pixel of the stripe: its colour is the error along the view (red: estimated too far away), its"
        f" line the error across the view ({factor:.3g} px per mm). Colours or lines that change slowly over the image"
        " indicate the lens or the laser plane; a random mixture is noise.",
        f"The image of {width} × {height} pixels with coloured dots where the stripe was seen.",
        [
            layer({"type": "point", "size": 22, "opacity": 1}, data, tooltip=said, x=x, y=y, color=colour),
            layer({"type": "rule", "color": MUTED, "strokeWidth": 0.8}, data, **ends),
            layer({"type": "rect", "filled": False, "stroke": MUTED, "strokeWidth": 0.7}, frame, **ends),
        ],
        height=tall,
    )


def _in_view(analysis: ErrorAnalysis, mount: Array) -> tuple[Array, Array]:
    """Errors of estimated points across the view, along image u and v, (m, 2), and along it, (m,) [mm]."""
    model, values, perturb = analysis.calibration.model, analysis.values, analysis.perturb
    R = (model.flange(values, perturb) @ mount)[0, :, :3, :3]
    errors = -1e3 * analysis.fitted_m
    x, y, z = (np.einsum("mj,mj->m", R[:, :, axis][model.dataset.points.pose], errors) for axis in range(3))
    u, v = (-y, x) if model.dataset.stripe_axis == "u" else (x, y)
    return np.stack([u, v], axis=-1), z
