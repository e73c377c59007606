"""Where in the image the errors are."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from robolaser.arrays import Array
from robolaser.model.sensors.stripe import Stripe
from robolaser.report.canvas import MUTED, Picture, picture, ticks
from robolaser.report.evidence import Evidence, some_rows
from robolaser.report.pictures.points import magnification

MOST = 600  # arrows that a picture carries


def image(evidence: Evidence) -> Picture | None:
    """Errors over the pixel plane: lines across the view, colour along it. Stripe scanners only."""
    dataset = evidence.calibration.model.dataset
    sensor, pixel = evidence.calibration.model.sensor, dataset.points.pixel
    if not isinstance(sensor, Stripe) or pixel is None or dataset.image_px is None:
        return None
    width, height = dataset.image_px
    across_mm, depth_mm = _in_view(evidence, sensor)
    rows = some_rows(evidence.fitted_mm, MOST)
    largest = float(np.percentile(np.linalg.norm(across_mm, axis=-1), 95))
    factor = magnification(largest, float(width))
    limit = float(np.percentile(np.abs(depth_mm), 98)) or 1.0

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        start = pixel[rows]
        ax.add_collection(
            LineCollection(
                list(np.stack([start, start + factor * across_mm[rows]], axis=1)), colors=MUTED, linewidths=0.7
            )
        )
        dots = ax.scatter(
            start[:, 0], start[:, 1], c=depth_mm[rows], cmap="coolwarm", vmin=-limit, vmax=limit, s=11, linewidths=0
        )
        bar = figure.colorbar(dots, ax=ax, shrink=0.8, pad=0.02, format=ticks)
        bar.outline.set_visible(False)
        bar.set_label("along the view [mm]")
        ax.set_aspect("equal")
        ax.set_xlim(-0.5, width - 0.5)
        ax.set_ylim(height - 0.5, -0.5)
        ax.spines[["top", "right"]].set_visible(True)
        ax.set_xlabel("u [px]")
        ax.set_ylabel("v [px]")

    return picture(
        "Errors over the image",
        f"Each dot is a pixel of the stripe: its colour is the error along the view (red: estimated too far), its"
        f" line the error across it ({factor:.3g} px a mm). Colours or lines that change slowly over the image speak of"
        " lens or light sheet; a random mixture is noise.",
        f"The image of {width} × {height} pixels with coloured dots where the stripe was seen.",
        paint,
    )


def _in_view(evidence: Evidence, sensor: Stripe) -> tuple[Array, Array]:
    """Errors of estimated points across the view, along image u and v, (m, 2), and along it, (m,) [mm]."""
    model, values, perturb = evidence.calibration.model, evidence.values, evidence.perturb
    R = (model.flange(values, perturb) @ sensor.mount(values, perturb))[0, :, :3, :3]
    errors = -1e3 * evidence.calibration.residuals
    x, y, z = (np.einsum("mj,mj->m", R[:, :, axis][model.dataset.points.pose], errors) for axis in range(3))
    u, v = (-y, x) if model.dataset.stripe_axis == "u" else (x, y)
    return np.stack([u, v], axis=-1), z
