"""How the search came down: the paper's Figure 8."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.estimation.multistart import subsampled
from robolaser.report.canvas import FITTED, HELD_OUT, MUTED, Picture, picture, plain_log
from robolaser.report.digits import millimetres
from robolaser.report.evidence import Evidence


def convergence(evidence: Evidence) -> Picture | None:
    """Best error so far over the generations, and that of the result."""
    calibration, history = evidence.calibration, evidence.calibration.history
    if history is None or len(history.best) < 2:
        return None
    rows = len(subsampled(calibration.model).dataset.points)
    best_mm = 1e3 * np.sqrt(np.where(np.isfinite(history.best), history.best, np.nan) / rows)
    final_mm = 1e3 * calibration.rms_m
    generation = np.arange(1, len(best_mm) + 1)

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.set_yscale("log")
        ax.plot(generation, best_mm, color=FITTED, drawstyle="steps-post")
        ax.axhline(final_mm, color=HELD_OUT, linestyle=(0, (4, 3)))
        at = (1.0, final_mm)
        ax.annotate("result", at, (-2, 4), textcoords="offset points", ha="right", color=HELD_OUT,
                    xycoords=ax.get_yaxis_transform())  # fmt: skip
        reached = ax.annotate("best candidate", (generation[len(generation) // 3], best_mm[len(best_mm) // 3]), (4, 6),
                              textcoords="offset points", color=FITTED)  # fmt: skip
        reached.set_in_layout(False)
        ax.set_xlim(1, len(best_mm))
        ax.set_xlabel("generation")
        ax.set_ylabel("RMS error [mm]", color=MUTED)
        plain_log(ax.yaxis)

    before, after = millimetres(best_mm[-1] / 1e3), millimetres(calibration.rms_m)
    return picture(
        "Convergence",
        f"Best error so far in each generation of {calibration.algorithm}, and that of the result, polished unless"
        " told otherwise. A curve that is still falling at the right edge stopped too early; a result far below it is"
        " what the polish found and the search had missed.",
        f"The best error falls to {before} in {len(best_mm)} generations; the result has {after}.",
        paint,
    )
