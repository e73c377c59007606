"""Which poses err."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.report.canvas import FITTED, HELD_OUT, MUTED, Picture, picture, plain_log
from robolaser.report.evidence import Evidence

STRIPS = 80  # poses up to which each point is drawn too
NAMED = 12  # poses up to which their names find room
LONG_NAME = 8


def poses(evidence: Evidence) -> Picture | None:
    """Root-mean-square error of each pose, fitted and held out."""
    calibration = evidence.calibration
    points, names = calibration.model.dataset.points, calibration.model.dataset.poses.names
    seen, fitted = evidence.per_pose(calibration.residuals)
    place = np.searchsorted(seen, points.pose)
    held_out = None if calibration.held_out is None else evidence.per_pose(calibration.held_out)[1]
    few = len(seen) <= STRIPS
    size = 4.0 if few else 2.2

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.set_yscale("log")
        if few:
            ax.plot(place, evidence.fitted_mm, "_", ms=5, mew=0.6, color=FITTED, alpha=0.35)
        ax.plot(fitted, "o", ms=size, mew=0, color=FITTED, label="fitted")
        if held_out is not None:
            ax.plot(held_out, "o", ms=size + 1, mfc="none", mew=1.0 if few else 0.5, color=HELD_OUT, label="held out")
        ax.set_xlim(-0.7, len(seen) - 0.3)
        floor = 0.3 * min(fitted.min(), np.percentile(evidence.fitted_mm, 10))
        ax.set_ylim(bottom=max(floor, 1e-6))
        labels = [names[i] for i in seen]
        if len(seen) <= NAMED:
            slanted = max(len(label) for label in labels) > LONG_NAME // 2
            ax.set_xticks(range(len(seen)), [label[: 2 * LONG_NAME] for label in labels], rotation=40 if slanted else 0,
                          ha="right" if slanted else "center")  # fmt: skip
        ax.set_xlabel("pose" if len(seen) <= NAMED else "pose, in the order of poses.csv")
        ax.set_ylabel("RMS error [mm]", color=MUTED)
        plain_log(ax.yaxis)
        figure.legend(loc="outside upper left", ncols=2)

    worst = int(np.argmax(fitted if held_out is None else held_out))
    return picture(
        "Errors of each pose",
        "Dots: root-mean-square error of a pose when it was fitted (blue) and when it was held out (orange)"
        f"{'; ticks: its points' if few else ''}. A lone high pose asks for a look at what was measured there, a step"
        f" or a slope along the run for what changed meanwhile. Worst: pose {names[seen[worst]]}.",
        f"Errors of {len(seen)} poses; the worst is {names[seen[worst]]}.",
        paint,
    )
