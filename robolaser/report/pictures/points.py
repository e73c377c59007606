"""Where the points are and where the model puts them: the paper's Figure 6."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from robolaser.report.canvas import FITTED, HELD_OUT, Picture, picture, ticks
from robolaser.report.evidence import Evidence, some_rows

MOST = 600  # arrows that a picture carries
LONG = 0.08  # of the picture's width: a long arrow
KNOWN = {"stripe": "known point", "point": "measured point", "socket": "socket"}
FRAME = {"stripe": "base frame", "point": "tracker's frame", "socket": "base frame"}


def points(evidence: Evidence) -> Picture | None:
    """Known points and the errors of the estimated ones, magnified, along the direction in which they spread least."""
    kind = evidence.calibration.model.dataset.kind
    known, errors = evidence.known, -evidence.calibration.residuals
    extent = np.ptp(known, axis=0)
    along = int(np.argmin(extent))
    across = [axis for axis in range(3) if axis != along]
    rows = some_rows(evidence.fitted_mm, MOST)
    factor = magnification(float(np.percentile(evidence.fitted_mm, 95)) / 1e3, float(extent[across].max()))
    start = 1e3 * known[rows][:, across]
    end = start + 1e3 * factor * errors[rows][:, across]

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        lines = LineCollection(list(np.stack([start, end], axis=1)), colors=HELD_OUT, linewidths=0.8)
        dots = ax.plot(*start.T, "o", ms=2.2, color=FITTED, zorder=3)[0]
        ax.add_collection(lines)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        for axis, number in ((ax.xaxis, across[0]), (ax.yaxis, across[1])):
            axis.set_label_text(f"{'xyz'[number]} [mm]")
            axis.set_major_formatter(ticks)
        figure.legend([dots, lines], [KNOWN[kind], f"error × {factor:g}"], loc="outside upper left", ncols=2)

    left_out = len(rows) < len(known)
    thinned = f" {len(rows)} of {len(known)} points are drawn, the largest errors among them." if left_out else ""
    return picture(
        "Known and estimated points",
        f"Seen along {'xyz'[along]} of the {FRAME[kind]}; a line leads from each {KNOWN[kind]} to the estimated one,"
        f" its length magnified {factor:g} times. Neighbours that err alike show something unmodelled; noise points"
        f" anywhere.{thinned}",
        f"Plan of the points with error lines magnified {factor:g} times.",
        paint,
    )


def magnification(error_m: float, extent_m: float) -> float:
    """The factor, 1, 2 or 5 times a power of ten, that shows an error as a long arrow."""
    if error_m <= 0 or extent_m <= 0:
        return 1.0
    wanted = np.log10(LONG * extent_m / error_m)
    power = np.floor(wanted)
    step = max((one for one in (1.0, 2.0, 5.0) if np.log10(one) <= wanted - power + 1e-9), default=1.0)
    return float(step * 10.0**power)
