"""Which poses err, in each of several series of errors."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.report.chart import (
    FITTED,
    HELD_OUT,
    NOISE,
    Chart,
    chart,
    colours,
    hover,
    layer,
    quantity,
    records,
    rule,
)

FEW: Final = 80  # poses up to which dots are large
RINGS: Final = ("held out", "before")
"""Series that are drawn as rings, so that dots at the same place are seen too."""
FLOOR: Final = "noise alone"


def pose_errors(
    dataset: Dataset, errors_m: Mapping[str, Array], *, reading: str, noise_m: float | None = None
) -> Chart:
    """Root-mean-square error of each pose, in the order of the run.

    Args:
        dataset: What was measured.
        errors_m: Errors of all rows by what they are called, the last one ranks the poses [m].
        reading: What the caption says of them.
        noise_m: What noise alone would give [m].
    """
    seen = np.unique(dataset.points.pose)
    time = dataset.poses.time_s
    seen = seen if time is None else seen[np.argsort(time[seen], kind="stable")]
    names = [dataset.poses.names[i] for i in seen]
    sizes = {name: [1e3 * rms(own[dataset.points.pose == i]) for i in seen] for name, own in errors_m.items()}
    title = "pose, in the order of " + ("poses.csv" if time is None else "the run")
    x, y = quantity("number", title, domain=(0, len(seen) + 1)), quantity("rms", "RMS error [mm]", log=True)
    of = {name: HELD_OUT if name in RINGS else FITTED for name in errors_m}
    colour = colours(of | ({} if noise_m is None else {FLOOR: NOISE}))
    dots = {"type": "point", "size": 46 if len(seen) <= FEW else 18}
    said = hover("pose", "series", rms="RMS error [mm]")
    layers = [
        layer(dots | ({"filled": False, "strokeWidth": 1.4} if name in RINGS else {}),
              records(number=np.arange(1, len(seen) + 1), pose=names, rms=own, series=name),
              tooltip=said, x=x, y=y, color=colour)
        for name, own in sizes.items()
    ]  # fmt: skip
    if noise_m is not None:
        floor = records(rms=1e3 * noise_m, series=FLOOR)
        layers.append(layer(rule(), floor, tooltip=hover("series", rms="RMS error [mm]"), y=y, color=colour))
    ranked = np.argsort(-np.array(list(sizes.values())[-1]), kind="stable")
    largest = [names[i] for i in ranked[:3]]
    return chart(
        "Errors of each pose",
        f"{reading} A single high pose calls for a look at what was measured there, a step or a slope along the run for"
        f" what changed meanwhile. Largest: {', '.join(largest)}.",
        f"Errors of {len(seen)} poses; the largest is that of {largest[0]}.",
        layers,
    )
