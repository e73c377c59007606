"""A laser stripe in an image: its centre in every line of pixels that crosses it."""

from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Image, Ints
from robolaser.vision.runs import FOOT, FULL, LEVEL, BrightRuns, ImageAxis, LineCentres, find_runs, measure

BEYOND_SIGMAS = 3.0  # fitted range beyond a flank: the whole Gaussian, and enough background for its slope
BEYOND_FULL_SIGMAS = 2.0
"""The same for saturated profiles, whose background is assumed level: flanks hardly distinguish slope and shift."""
BROADEST_FULL = 12  # saturated pixels of a fit; more are glare, and the centre of gravity between the flanks is kept
FARTHEST = 0.5  # largest distance of a fit's centre from the centre of gravity, and its deviation [widths]
STEPS = 4  # Gauss-Newton steps; the start is good to a tenth of the width
DAMPING = 1e-3  # added to the normal equations' diagonal while stepping, as a share
SETTLED = 1e-9  # always added, so that the equations have a solution where pixels have no information
STILL = 1e-3  # largest change of centre and width, in widths, of a converged fit
LONGEST = (-0.4, 0.6)  # largest steps of the Gaussian's width, as shares; its centre moves by less than one width
FEWEST = 7  # pixels for a Gaussian's five unknowns


def find_line_centres(image: Image, axis: ImageAxis) -> LineCentres:
    """Find every bright run that may be the stripe, and its centre to a fraction of a pixel.

    Runs cut by the image's border have no centre and are left out. The image is grey, (height, width); a stripe along
    the image axis "v" has one centre per row, along "u" one per column.

    Returns:
        The candidates, by line and then by position in the line.
    """
    runs = find_runs(image, axis)
    found = _gaussian_fit(runs, measure(runs))
    return found.at(np.isfinite(found.centre) & np.isfinite(found.std))


def _gaussian_fit(runs: BrightRuns, profiles: LineCentres) -> LineCentres:
    """Fit A exp(-(x - m)² / 2 s²) + c + d x to each run by least squares, saturated pixels left out.

    Where no Gaussian fits, the centre of gravity is kept. A centre's deviation is by the image's noise, or by the fit's
    residuals where these are larger.
    """
    whole = np.isfinite(profiles.centre) & np.isfinite(profiles.foot)
    at = np.flatnonzero(whole & (profiles.full <= BROADEST_FULL))
    full = profiles.full[at] > 0
    origin = np.rint(profiles.centre[at]).astype(np.int64)
    start = _start(profiles, at, origin)
    reach = profiles.width[at] / 2 + np.where(full, BEYOND_FULL_SIGMAS, BEYOND_SIGMAS) * start[:, 2]
    before, after = runs.room()
    low = np.maximum(before[at], origin - np.ceil(reach).astype(np.int64))
    high = np.minimum(after[at], origin + np.ceil(reach).astype(np.int64))
    gaussian, second, scatter, count = _fitted(*_pixels(runs, at, low, high, origin), start, full)
    centre = gaussian[:, 1]
    known = (count >= FEWEST) & (gaussian[:, 0] > 0)
    variance = np.where(known, second * np.maximum(runs.noise**2, scatter), 0.0)
    farthest = FARTHEST * profiles.width[at]
    fits = (variance > 0) & (variance <= farthest**2) & (np.abs(centre - start[:, 1]) <= farthest)
    found, std = profiles.centre.copy(), profiles.std.copy()
    found[at[fits]] = (origin + centre)[fits]
    std[at[fits]] = np.sqrt(variance[fits])
    return replace(profiles, centre=found, std=std)


def _start(profiles: LineCentres, at: Ints, origin: Ints) -> Array:
    """Height, centre, width, background and its slope by two widths of a profile, (n, 5)."""
    width, rise = profiles.width[at], profiles.peak[at] - profiles.ground[at]
    breadth = np.sqrt(np.maximum(profiles.foot[at] ** 2 - width**2, 0.0) / (8 * np.log(LEVEL / FOOT)))
    breadth = np.clip(breadth, width / 6, width / 1.5)
    height = np.where(profiles.full[at] > 0, LEVEL * rise * np.exp(width**2 / (8 * breadth**2)), rise)
    ground = profiles.ground[at]
    return np.stack([height, profiles.centre[at] - origin, breadth, ground, np.zeros_like(ground)], axis=-1)


def _pixels(runs: BrightRuns, at: Ints, low: Ints, high: Ints, origin: Ints) -> tuple[Array, Array, Array]:
    """Distances x from `origin` (k,), and grey of the pixels there and whether they are fitted, 1 or 0, (n, k)."""
    reach = np.maximum(origin - low, high - origin).max(initial=0)
    x = np.arange(-reach, reach + 1)
    column = origin[:, None] + x
    grey = runs.across[runs.line[at][:, None], np.clip(column, 0, runs.across.shape[1] - 1)].astype(np.float64)
    used = (column >= low[:, None]) & (column <= high[:, None]) & (grey < FULL)
    return x.astype(np.float64), grey, used.astype(np.float64)


def _fitted(x: Array, grey: Array, used: Array, start: Array, full: Bools) -> tuple[Array, Array, Array, Array]:
    """Damped Gauss-Newton steps for each profile until it has converged.

    Args:
        x: Positions of the pixels, (k,) [px].
        grey: (n, k).
        used: 1 for the pixels that are fitted, else 0, (n, k).
        start: A, m, s, c and d to start from, (n, 5).
        full: Whether the profile is saturated; then d stays 0, (n,).

    Returns:
        A, m, s, c and d, (n, 5); the variance of m for pixels of variance 1, the variance of the residuals, and the
        number of fitted pixels, (n,).
    """
    gaussian, diagonal = start.copy(), np.arange(5)
    moving = np.arange(len(start))
    for _ in range(STEPS):
        N, right, _ = _equations(x, grey[moving], used[moving], gaussian[moving], full[moving])
        N[:, diagonal, diagonal] += DAMPING * N[:, diagonal, diagonal] + SETTLED
        step = np.linalg.solve(N, right[..., None])[..., 0]
        s = gaussian[moving, 2]
        step[:, 1] = np.clip(step[:, 1], -s, s)
        step[:, 2] = np.clip(step[:, 2], LONGEST[0] * s, LONGEST[1] * s)
        gaussian[moving] += step
        moving = moving[np.abs(step[:, 1:3]).max(axis=1) > STILL * s]
    N, _, squares = _equations(x, grey, used, gaussian, full)
    N[:, diagonal, diagonal] += SETTLED * N[:, diagonal, diagonal] + SETTLED
    second = np.linalg.solve(N, np.eye(5)[None, :, 1:2])[:, 1, 0]
    count = used.sum(axis=1)
    return gaussian, np.asarray(second, np.float64), squares / np.maximum(count - 5, 1), count


def _equations(x: Array, grey: Array, used: Array, gaussian: Array, full: Bools) -> tuple[Array, Array, Array]:
    """Normal matrices (n, 5, 5), their right sides (n, 5), and the sums of squared residuals, (n,)."""
    A, m, s, c, d = (gaussian[:, k, None] for k in range(5))
    z = (x - m) / s
    g = np.exp(-0.5 * z * z) * used
    shift = A * g * z / s
    J = np.stack([g, shift, shift * z, used, x * used], axis=1)
    J[full, 4] = 0.0
    left = used * (grey - c - d * x) - A * g
    return J @ np.swapaxes(J, 1, 2), (J @ left[..., None])[..., 0], np.einsum("ij,ij->i", left, left)
