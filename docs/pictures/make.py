"""The picture of the demo: errors along the laser stripe, without and with the sheet's roll in the model.

Run from the repository's root: .venv/bin/python docs/pictures/make.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from robolaser import Plan, load
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.result import Calibration
from robolaser.vision.recordings import points_from_images

ROOT = Path(__file__).parents[2]
PICTURE = Path(__file__).with_name("etna-s2.png")
INK, LINES = "#3c434a", "#2b6cb1"
GAP_PX = 30  # where the stripe is not seen, no line is drawn


def draw(results: list[tuple[str, Calibration]]) -> Figure:
    """Length of each held-out error over the place along the stripe, one line a pose, all panels at one scale."""
    figure = Figure(figsize=(9, 3.4), dpi=150, layout="constrained", facecolor="white")
    panels = figure.subplots(1, len(results), sharex=True, sharey=True)
    for ax, (title, calibration) in zip(panels, results, strict=True):
        points, errors = calibration.model.dataset.points, calibration.held_out
        assert points.pixel is not None
        assert points.sensor is not None
        assert errors is not None
        along, length_mm, stripe = points.pixel[:, 1], 1e3 * np.linalg.norm(errors, axis=-1), points.sensor == 0
        for pose in np.unique(points.pose):
            rows = np.flatnonzero((points.pose == pose) & stripe)
            rows = rows[np.argsort(along[rows])]
            gaps = np.flatnonzero(np.diff(along[rows]) > GAP_PX) + 1
            for part in np.split(rows, gaps):
                ax.plot(along[part], length_mm[part], color=LINES, linewidth=1.1, alpha=0.75)
        ax.set_title(f"{title}: {np.sqrt((length_mm[stripe] ** 2).mean()):.2f} mm RMS", fontsize=11, color=INK)
        ax.set_xlabel("place along the stripe, image v [px]", color=INK)
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(color="#dfe3e8", linewidth=0.7)
        ax.tick_params(colors=INK, length=0)
    panels[0].set_ylim(bottom=0)
    panels[0].set_ylabel("3-D error on held-out poses [mm]", color=INK)
    return figure


def main() -> None:
    """Extract the points once, calibrate twice, draw."""
    _, dataset = points_from_images(load(ROOT / "examples" / "etna-s2"))
    plans = {"the paper's 14 parameters": Plan(), "with the roll of the laser plane": Plan(effects=("laser_roll",))}
    results = [(title, calibrate(dataset, plan)) for title, plan in plans.items()]
    draw(results).savefig(PICTURE)
    for title, calibration in results:
        print(
            f"{title}: held out {calibration.held_out_rms_m}, fitted {calibration.rms_m}, {calibration.seconds:.1f} s"
        )


if __name__ == "__main__":
    main()
