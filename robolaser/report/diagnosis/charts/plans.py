"""Errors at the points, before and after, on the same scale."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from robolaser.arrays import Array
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.canvas import FITTED, HELD_OUT, INK, MUTED, Picture, picture, ticks
from robolaser.report.evidence import known_points, lengths_mm, some_rows
from robolaser.report.pictures.points import FRAME, KNOWN, magnification

WIDE = 1.6
"""Breadth over height, from which on the panels stand above each other."""
MOST = 400  # arrows in each panel


def plans(diagnosis: Diagnosis) -> Picture:
    """Two plans of the points with magnified errors: in the calibrated model, and with all effects in it."""
    model = diagnosis.model
    values = model.parameters.values(diagnosis.x[None])
    known = 1e3 * known_points(model, values, model.perturb(values))
    extent = np.ptp(known, axis=0)
    along = int(np.argmin(extent))
    across = [axis for axis in range(3) if axis != along]
    if extent[across[1]] > extent[across[0]]:
        across.reverse()
    both = {"before": diagnosis.before_m, "after": diagnosis.after_m}
    shown = both if diagnosis.findings else {"now": diagnosis.after_m}
    lengths = lengths_mm(next(iter(shown.values())))
    rows = some_rows(lengths, MOST)
    factor = magnification(float(np.percentile(lengths, 95)), 2 * float(extent[across].max()))

    def paint(figure: Figure) -> None:
        wide = extent[across[0]] > WIDE * extent[across[1]]
        grid = (len(shown), 1) if wide else (1, len(shown))
        panels = np.ravel(figure.subplots(*grid, sharex=True, sharey=True))
        for ax, (name, errors) in zip(panels, shown.items(), strict=True):
            colour = HELD_OUT if name == "before" else FITTED
            _panel(ax, known[rows][:, across], -1e3 * factor * errors[rows][:, across], colour)
            ax.annotate(name, (0, 1), (0, 4), xycoords="axes fraction", textcoords="offset points", color=colour)
            ax.set_xlabel(f"{'xyz'[across[0]]} [mm]")
            ax.label_outer()
        panels[0].set_ylabel(f"{'xyz'[across[1]]} [mm]")

    kind = model.dataset.kind
    panels = "before and after the effects were added" if diagnosis.findings else "as the model leaves them"
    return picture(
        "Errors before and after" if diagnosis.findings else "Errors at the points",
        f"Seen along {'xyz'[along]} of the {FRAME[kind]}: a line leads from each {KNOWN[kind]} to where it is predicted"
        f" from other poses, {panels}; all are magnified {factor:g} times. What is left should point anywhere.",
        f"Plans of the points with error lines magnified {factor:g} times.",
        paint,
    )


def _panel(ax: Axes, start: Array, arrows: Array, colour: str) -> None:
    ax.add_collection(LineCollection(list(np.stack([start, start + arrows], axis=1)), colors=colour, linewidths=0.9))
    ax.plot(*start.T, "o", ms=1.6, mew=0, color=INK, alpha=0.6, zorder=3)
    ax.set_aspect("equal", adjustable="box")
    ax.autoscale_view()
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(ticks)
        axis.label.set_color(MUTED)
