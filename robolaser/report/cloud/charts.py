"""A cloud from above: its heights, its scatter, and how far its points lie off the largest plane."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from robolaser.arrays import Array
from robolaser.report.canvas import FITTED, HELD_OUT, Picture, picture, ticks
from robolaser.scan.quality import Quality

CELLS = 220, 160, 120, 90, 60  # along the longer side of a picture; the finest that leaves no gaps between stripes
FILLED = 0.95  # of the area that the coarsest cells cover
CLEAR = 1.0, 99.0  # percentiles between which colours are spread: a stray point would take them all
BINS = 60
FEWEST = 10  # points that make a picture


def heights(quality: Quality) -> Picture | None:
    """The cloud seen along the direction in which it is thinnest, coloured by how far it stands out."""
    if len(quality.vertices) < FEWEST:
        return None
    across, along, out, what = _view(quality)
    caption = (
        f"Each cell is the mean of the points in it, {what}. Steps between neighbouring stripes, or copies of one edge,"
        " say that the calibration does not fit this recording."
    )
    return _map("Heights", caption, across, along, 1e3 * out, "viridis", "height [mm]")


def scatter(quality: Quality) -> Picture | None:
    """The same view, coloured by the scatter of its points."""
    std = quality.vertices["std"].astype(np.float64)
    if len(std) < FEWEST or not np.isfinite(std).all():
        return None
    across, along, _, _ = _view(quality)
    caption = (
        "What noise does to a point: that of the stripe's middle carried through ray and sheet, that of the joints"
        " through the arm. It grows where rays meet the sheet at a flat angle. What the calibrated model did not"
        " explain counts as noise of the joints; errors that all points share are not in it."
    )
    return _map("Scatter of the points", caption, across, along, 1e3 * std, "magma", "std [mm]")


def off_plane(quality: Quality) -> Picture | None:
    """How far the plane's points lie off it, against what their scatter promises."""
    plane = quality.plane
    if plane is None:
        return None
    off = 1e3 * plane.distance[plane.on]
    std = 1e3 * quality.vertices["std"].astype(np.float64)[plane.on]
    limit = 1.5 * float(np.percentile(np.abs(off), CLEAR[1])) or 1.0
    edges = np.linspace(-limit, limit, BINS + 1)
    middles = (edges[1:] + edges[:-1]) / 2

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ax.hist(off, edges.tolist(), density=True, color=FITTED, alpha=0.6, label="found")
        if np.isfinite(std).all() and (std > 0).all():
            some = std[:: max(1, len(std) // 2000), None]
            bells = np.exp(-0.5 * (middles / some) ** 2) / (np.sqrt(2 * np.pi) * some)
            ax.plot(middles, bells.mean(axis=0), color=HELD_OUT, label="promised by std")
        ax.set_xlabel("distance from the plane [mm]")
        ax.xaxis.set_major_formatter(ticks)
        ax.set_yticks([])
        figure.legend(loc="outside upper left", ncols=2)

    return picture(
        "Points about the largest plane",
        "Distances of the points that lie on the largest plane. Wider than promised: stripes do not agree with each"
        " other, and the calibration has its share; narrower: the surface is met at a flat angle to the error, or the"
        " calibration took for noise what its model did not explain.",
        f"Histogram of {int(plane.on.sum())} distances from a plane, root mean square {1e3 * plane.rms_m:.3g} mm.",
        paint,
    )


PICTURES: tuple[Callable[[Quality], Picture | None], ...] = (heights, scatter, off_plane)


def _view(quality: Quality) -> tuple[tuple[str, Array], tuple[str, Array], Array, str]:
    """Names and values of what is drawn to the right and up, what stands out, and how to say it."""
    places = quality.places
    low, high = np.percentile(places, CLEAR, axis=0)
    thin = int(np.argmin(high - low))
    right, up = (axis for axis in range(3) if axis != thin)
    names = tuple("xyz"[axis] for axis in (right, up))
    across, along = (names[0], places[:, right]), (names[1], places[:, up])
    if quality.plane is not None:
        return across, along, quality.plane.distance, "above the largest plane"
    return across, along, places[:, thin], f"by its {'xyz'[thin]} in the base frame"


def _map(
    title: str, caption: str, across: tuple[str, Array], along: tuple[str, Array], value: Array, colours: str, unit: str
) -> Picture:
    sides = [1e3 * np.percentile(one, CLEAR) for _, one in (across, along)]
    margin = 0.03 * max(float(np.ptp(side)) for side in sides) or 1.0
    (left, right), (low, high) = ((side[0] - margin, side[1] + margin) for side in sides)
    places = 1e3 * across[1], 1e3 * along[1]
    edges = _edges(places, (left, right), (low, high))
    count = np.histogram2d(*places, bins=edges)[0]
    total = np.histogram2d(*places, bins=edges, weights=value)[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.ma.masked_invalid(total / count).T
    shown = mean.compressed()
    least, most = np.percentile(shown, CLEAR) if len(shown) else (0.0, 1.0)

    def paint(figure: Figure) -> None:
        ax = figure.subplots()
        ends = edges[0][0], edges[0][-1], edges[1][0], edges[1][-1]
        image: Any = ax.imshow(
            mean, extent=ends, origin="lower", cmap=colours, vmin=least, vmax=most, interpolation="nearest"
        )
        ax.grid(visible=False)
        bar = figure.colorbar(image, ax=ax, shrink=0.8, pad=0.02, format=ticks)
        bar.outline.set_visible(False)
        bar.set_label(unit)
        for axis, (name, _) in ((ax.xaxis, across), (ax.yaxis, along)):
            axis.set_label_text(f"{name} [mm]")
            axis.set_major_formatter(ticks)

    alt = f"Map of the cloud, {right - left:.3g} by {high - low:.3g} mm, coloured by {unit}."
    return picture(title, caption, alt, paint)


def _edges(places: tuple[Array, Array], *sides: tuple[float, float]) -> list[Array]:
    """Edges of the cells along both sides."""
    longest = max(end - start for start, end in sides)
    tried = []
    for cells in CELLS:
        size = longest / cells
        edges = [np.arange(start, end + size, size) for start, end in sides]
        tried.append((edges, size**2 * np.count_nonzero(np.histogram2d(*places, bins=edges)[0])))
    covered = tried[-1][1]
    return next(edges for edges, area in tried if area >= FILLED * covered or edges is tried[-1][0])
