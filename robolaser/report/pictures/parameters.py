"""How the parameters settled: the paper's Figure 7."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.report.canvas import LINES, MUTED, Picture, picture, spread
from robolaser.report.evidence import Evidence

LABEL_APART = 0.058  # of the axes' height: a line of text
MOST = 16  # lines that an eye can follow


def parameters(evidence: Evidence) -> Picture | None:
    """Each parameter of the best candidate, scaled to its bounds, over the generations."""
    calibration, history = evidence.calibration, evidence.calibration.history
    if history is None or len(history.best) < 2:
        return None
    names = history.names[:MOST]
    model = calibration.model.parameters
    columns = model.columns(names)
    scaled = (history.x[:, : len(names)] - model.lower[columns]) / model.width[columns]
    final = (calibration.x[columns] - model.lower[columns]) / model.width[columns]
    changes = np.flatnonzero(np.any(np.diff(scaled, axis=0, prepend=np.nan) != 0, axis=1))
    shown = np.unique([*changes, len(scaled) - 1])

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        heights = spread(final.tolist(), LABEL_APART)
        for i, name in enumerate(names):
            colour, dashes = LINES[i % len(LINES)], "-" if i < len(LINES) else (0, (4, 2))
            ax.plot(shown + 1, scaled[shown, i], color=colour, linestyle=dashes, linewidth=1.1, drawstyle="steps-post")
            ax.plot([1.02], [final[i]], "o", ms=3.5, color=colour, transform=ax.get_yaxis_transform(), clip_on=False)
            leader = {"arrowstyle": "-", "color": colour, "linewidth": 0.6, "shrinkA": 1, "shrinkB": 2}
            frame = ax.get_yaxis_transform()
            label = ax.annotate(
                name, (1.02, final[i]), (1.06, heights[i]), frame, frame, leader, va="center", color=colour
            )
            label.set_annotation_clip(False)
        ax.set_xlim(1, len(scaled))
        ax.set_ylim(-0.02, 1.02)
        ax.set_yticks([0, 0.5, 1], ["lower\nbound", "0.5", "upper\nbound"])
        ax.set_xlabel("generation")
        ax.yaxis.label.set_color(MUTED)

    return picture(
        "Parameters over the generations",
        "The best candidate's parameters, scaled to their bounds; dots at the right are the final values. Lines that"
        " wander while the error no longer falls belong to parameters that these data hardly fix, and a dot at 0 or 1"
        " to one that wants out of its bounds.",
        f"Lines for {', '.join(names)} between lower bound 0 and upper bound 1.",
        paint,
    )
