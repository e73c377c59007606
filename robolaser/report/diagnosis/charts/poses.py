"""Which poses erred before the effects were in the model, and which still do."""

import numpy as np
from matplotlib.figure import Figure

from robolaser.calibration.result import rms
from robolaser.diagnosis.result import Diagnosis
from robolaser.report.canvas import FITTED, HELD_OUT, MUTED, NOISE, Picture, picture, plain_log

FEW = 80  # poses up to which dots find room


def poses(diagnosis: Diagnosis) -> Picture:
    """Root-mean-square error of each pose on held-out data, before and after, over the order of the run."""
    dataset = diagnosis.observed
    seen = np.unique(dataset.points.pose)
    before, after = (
        np.array([1e3 * rms(errors[dataset.points.pose == number]) for number in seen])
        for errors in (diagnosis.before_m, diagnosis.after_m)
    )
    time = dataset.poses.time_s
    order = np.arange(len(seen)) if time is None else np.argsort(time[seen], kind="stable")
    size = 4.0 if len(seen) <= FEW else 2.2

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.set_yscale("log")
        floor = 1e3 * diagnosis.gap.noise_floor_m
        ax.axhline(floor, color=NOISE, linestyle=(0, (4, 3)), label="noise alone")
        if diagnosis.findings:
            ax.plot(before[order], "o", ms=size + 1, mfc="none", mew=1.0, color=HELD_OUT, label="before")
        ax.plot(after[order], "o", ms=size, mew=0, color=FITTED, label="after" if diagnosis.findings else "each pose")
        ax.set_xlim(-0.7, len(seen) - 0.3)
        ax.set_xlabel("pose, in the order of poses.csv" if time is None else "pose, in the order of the run")
        ax.set_ylabel("RMS error when held out [mm]", color=MUTED)
        plain_log(ax.yaxis)
        figure.legend(loc="outside upper left", ncols=3)

    names = [dataset.poses.names[seen[i]] for i in np.argsort(-after)[:3]]
    return picture(
        "Errors of each pose",
        "Each pose predicted by fits that did not see it. A slope or a step along the run speaks of something that"
        f" changed meanwhile. Largest now: {', '.join(names)}.",
        f"Errors of {len(seen)} poses before and after; the largest now is that of {names[0]}.",
        paint,
    )
