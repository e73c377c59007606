"""The picture of the cell's page: ball and step scanned from both sides, with the gear's play in the model and without.

Run from the repository's root: .venv/bin/python docs/pictures/cell.py WITH.ply WITHOUT.ply
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from robolaser.arrays import Array
from robolaser.scan.ply import map_ply, positions_of

PICTURE = Path(__file__).with_name("cell-cloud.png")
INK, BALL, STEP = "#3c434a", "#2b6cb1", "#d9701e"
CELL_MM = 1.5
CUTS = ((44, 46, BALL), (-31, -29, STEP))  # y [mm]: through the ball's middle, through the step's


def draw(clouds: list[tuple[str, Array]]) -> Figure:
    """Heights of the first cloud from above, and two cuts through each, all at one scale."""
    figure = Figure(figsize=(9, 4.2), dpi=120, layout="constrained", facecolor="white")
    panels = figure.subplot_mosaic("am;an", width_ratios=(1, 1.7))
    above, cuts = panels["a"], (panels["m"], panels["n"])
    x, y, z = clouds[0][1].T
    edges = [np.arange(side.min(), side.max() + CELL_MM, CELL_MM) for side in (x, y)]
    with np.errstate(invalid="ignore"):
        height = np.histogram2d(x, y, edges, weights=z)[0] / np.histogram2d(x, y, edges)[0]
    ends = edges[0][0], edges[0][-1], edges[1][0], edges[1][-1]
    image = above.imshow(height.T, extent=ends, origin="lower", cmap="viridis", vmin=0)
    above.set_title("from above", fontsize=11, color=INK)
    above.set_xlabel("x [mm]", color=INK)
    above.set_ylabel("y [mm]", color=INK)
    bar = figure.colorbar(image, ax=above, shrink=0.7, pad=0.02)
    bar.set_label("height [mm]", color=INK)
    bar.outline.set_visible(False)
    for cut, (title, places) in zip(cuts, clouds, strict=True):
        for low, high, colour in CUTS:
            near = places[(places[:, 1] > low) & (places[:, 1] < high)]
            cut.scatter(near[:, 0], near[:, 2], s=2, color=colour, linewidth=0)
            above.axhline((low + high) / 2, color=colour, linewidth=1)
        cut.set_title(f"cut along both lines, {title}", fontsize=11, color=INK)
        cut.set_ylim(-3, 39)
        cut.set_aspect("equal")
        cut.set_ylabel("height [mm]", color=INK)
    cuts[-1].set_xlabel("x [mm]", color=INK)
    for ax in (above, *cuts):
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(colors=INK, length=0)
    return figure


def main() -> None:
    titles = "with play in the model", "without play"
    clouds = [1e3 * positions_of(map_ply(Path(path))) for path in sys.argv[1:]]
    draw(list(zip(titles, clouds, strict=True))).savefig(PICTURE)


if __name__ == "__main__":
    main()
