"""The middle of the Gaussian that fits a stripe's profile best."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled import Loops
from robolaser.vision.board import Image
from robolaser.vision.line_centres.centre_of_gravity import Profiles
from robolaser.vision.profile_levels import DAMPING, FEWEST, FOOT, FULL, LEVEL, LONGEST, SETTLED, STEPS, STILL
from robolaser.vision.runs import Runs

BEYOND_SIGMAS = 3.0
"""Pixels fitted beyond a flank: where the gaussian ends, and enough ground beside it to know its slope."""
BEYOND_FULL_SIGMAS = 2.0
"""The same for saturated profiles, whose ground is taken for level: flanks alone tell its slope from a shift badly."""
BROADEST_FULL = 12
"""Saturated pixels beyond which light is glare and no gaussian: the centre of gravity between the flanks stands."""
FARTHEST = 0.5
"""Distance of the Gaussian's centre from the centre of gravity, and its deviation, that a fit has at most [widths]."""

_LOOPS = Loops("robolaser.vision.gaussian_loops", pays_after=100_000)  # runs of bright pixels


def gaussian_fit(runs: Runs, profiles: Profiles) -> tuple[Array, Array]:
    """Fit A exp(-(x - m)² / 2 s²) + c + d x to each run by least squares, saturated pixels left out.

    Where no gaussian fits, the centre of gravity stands.

    Args:
        runs: Where light is (n).
        profiles: What the centre of gravity knows of it.

    Returns:
        The centre and its standard deviation, (n,) [px]: by the image's noise, or by what the fit leaves where that
        is more.
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
    centre, variance = np.empty(len(at)), np.empty(len(at))
    loops = _LOOPS.after(len(at)) if runs.across.dtype == np.uint8 else None
    fit = loops.fit if loops else _fit
    fit(runs.across, runs.line[at], low, high, origin, start, full, runs.noise**2, centre, variance)
    farthest = FARTHEST * profiles.width[at]
    fits = (variance > 0) & (variance <= farthest**2) & (np.abs(centre - start[:, 1]) <= farthest)
    found, std = profiles.centre.copy(), profiles.std.copy()
    found[at[fits]] = (origin + centre)[fits]
    std[at[fits]] = np.sqrt(variance[fits])
    return found, std


def _start(profiles: Profiles, at: Ints, origin: Ints) -> Array:
    """Height, centre, breadth, ground and its slope that two widths of a profile speak for, (n, 5)."""
    width, rise = profiles.width[at], profiles.peak[at] - profiles.ground[at]
    breadth = np.sqrt(np.maximum(profiles.foot[at] ** 2 - width**2, 0.0) / (8 * np.log(LEVEL / FOOT)))
    breadth = np.clip(breadth, width / 6, width / 1.5)
    height = np.where(profiles.full[at] > 0, LEVEL * rise * np.exp(width**2 / (8 * breadth**2)), rise)
    ground = profiles.ground[at]
    return np.stack([height, profiles.centre[at] - origin, breadth, ground, np.zeros_like(ground)], axis=-1)


def _fit(
    across: Image,
    line: Ints,
    low: Ints,
    high: Ints,
    origin: Ints,
    start: Array,
    full: Bools,
    noise: float,
    centre: Array,
    variance: Array,
) -> None:
    """The twin of `gaussian_loops.fit`, which says what it takes."""
    reach = np.maximum(origin - low, high - origin).max(initial=0)
    x = np.arange(-reach, reach + 1)
    column = origin[:, None] + x
    grey = across[line[:, None], np.clip(column, 0, across.shape[1] - 1)].astype(np.float64)
    used = (column >= low[:, None]) & (column <= high[:, None]) & (grey < FULL)
    w, gaussian, diagonal = used.astype(np.float64), start.copy(), np.arange(5)
    active = np.ones(len(line), dtype=np.bool_)
    for step in range(STEPS + 1):
        A, m, s, c, d = (gaussian[:, k, None] for k in range(5))
        z = (x - m) / s
        g = np.exp(-0.5 * z * z)
        J = w[..., None] * np.stack(
            [g, A * g * z / s, A * g * z * z / s, np.ones_like(g), x * np.ones_like(g)], axis=-1
        )
        J[full, :, 4] = 0.0
        left = w * (grey - A * g - c - d * x)
        N = np.swapaxes(J, 1, 2) @ J
        N[:, diagonal, diagonal] += (DAMPING if step < STEPS else SETTLED) * N[:, diagonal, diagonal] + SETTLED
        if step < STEPS:
            steps = np.linalg.solve(N, np.swapaxes(J, 1, 2) @ left[..., None])[..., 0]
            steps[:, 1] = np.clip(steps[:, 1], -gaussian[:, 2], gaussian[:, 2])
            steps[:, 2] = np.clip(steps[:, 2], LONGEST[0] * gaussian[:, 2], LONGEST[1] * gaussian[:, 2])
            s = gaussian[:, 2]
            gaussian = gaussian + np.where(active[:, None], steps, 0.0)
            active &= np.abs(steps[:, 1:3]).max(axis=1) > STILL * s
    count = used.sum(axis=1)
    scatter = (left**2).sum(axis=1) / np.maximum(count - 5, 1)
    second = np.linalg.solve(N, np.eye(5)[None, :, 1:2])[:, 1, 0]
    centre[:] = gaussian[:, 1]
    variance[:] = np.where((count >= FEWEST) & (gaussian[:, 0] > 0), second * np.maximum(noise, scatter), 0.0)
