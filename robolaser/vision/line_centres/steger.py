"""The ridge of the stripe's light as differential geometry sees it.

C. Steger, An unbiased detector of curvilinear structures, IEEE Trans. PAMI 20 (1998) 113-125. The image is smoothed by
a Gaussian along and across the stripe, so neighbouring lines share their noise. A profile that is steeper on one side
is found towards the steep side: the paper's correction for bars of uneven contrast is not made here, a laser's profile
is no bar.
"""

import cv2
import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.vision.board import Image
from robolaser.vision.profiles import Profiles
from robolaser.vision.runs import Runs

HALF_PER_WIDTH = 0.6  # half the breadth of the bar that a stripe is taken for, over its width between the flanks
NARROWEST = 0.8  # least smoothing [px]: less does not reach the next pixel
CUT = 4.0  # smoothing ends after this many standard deviations
TAYLOR_PX = 0.005  # error [px] of the ridge beside the noise's: the light is no parabola between two pixels
FARTHEST_FROM_PIXEL = 0.6
"""Distance of the ridge from the pixel whose slopes give it [px]; more than a half, lest noise leave it without any."""
BORDER = 2.5
"""Lines at the image's border, in standard deviations of the smoothing, that have no ridge: none is known beyond."""
STEPS = 8  # pixels that are walked from the centre of gravity at most
FARTHEST = 0.5  # distance of the ridge from the centre of gravity, in widths, beyond which it is another's
ASLANT = 0.3  # cosine between ridge's normal and line of pixels below which the line hardly crosses the ridge


def steger(runs: Runs, profiles: Profiles) -> tuple[Array, Array]:
    """Find where each line of pixels crosses the ridge.

    Args:
        runs: Where light is (n).
        profiles: What the centre of gravity knows of it; the typical width gives the smoothing.

    Returns:
        The centre and its standard deviation by the image's noise, (n,) [px]; NaN where there is no ridge.
    """
    centre, std = np.full(len(runs), np.nan), np.full(len(runs), np.nan)
    at = np.flatnonzero(np.isfinite(profiles.centre))
    if len(at) == 0:
        return centre, std
    sigma = max(NARROWEST, HALF_PER_WIDTH * float(np.median(profiles.width[at])) / float(np.sqrt(3)))
    margin = int(np.ceil(CUT * sigma)) + STEPS
    start = max(0, int(runs.first[at].min()) - margin)
    part = runs.across[:, start : int(runs.last[at].max()) + margin + 1]
    slopes = _derivatives(part, sigma)
    line, column = runs.line[at], np.rint(profiles.centre[at]).astype(np.int64) - start
    for _ in range(STEPS):
        step = np.rint(np.nan_to_num(_crossing(slopes, line, column)[0]))
        column = np.clip(column + np.clip(step, -1, 1).astype(np.int64), 1, part.shape[1] - 2)
    off, curve, across = _crossing(slopes, line, column)
    beyond = np.where(off < 0, -1, 1)
    other = beyond + _crossing(slopes, line, column + beyond)[0]
    near, far = np.abs(off) ** 3, np.abs(beyond - off) ** 3
    found = start + column + (far * off + near * other) / (near + far)
    rim = BORDER * sigma
    good = (
        (line >= rim)
        & (line < len(part) - rim)
        & (np.abs(off) <= FARTHEST_FROM_PIXEL)
        & (curve < 0)
        & (np.abs(across) > ASLANT)
    )
    good &= np.abs(found - profiles.centre[at]) <= FARTHEST * profiles.width[at]
    centre[at[good]] = found[good]
    spread = runs.noise / (np.sqrt(8 * np.pi) * sigma**2)
    std[at[good]] = np.hypot(spread / np.abs(curve * across), TAYLOR_PX)[good]
    return centre, std


def _derivatives(part: Image, sigma: float) -> tuple[Array, ...]:
    """Smoothed slopes and curvatures x, y, xx, xy, yy of an image, (lines, length) each."""
    radius = int(np.ceil(CUT * sigma))
    x = np.arange(-radius, radius + 1)
    kernel = np.exp(-0.5 * (x / sigma) ** 2)
    kernel /= kernel.sum()
    slope = x * kernel / (x * x * kernel).sum()
    curve = (x * x - (x * x * kernel).sum()) * kernel
    curve *= 2 / (x * x * curve).sum()
    pairs = ((slope, kernel), (kernel, slope), (curve, kernel), (slope, slope), (kernel, curve))
    border = cv2.BORDER_REFLECT_101
    return tuple(np.asarray(cv2.sepFilter2D(part, cv2.CV_32F, kx, ky, borderType=border)) for kx, ky in pairs)


def _crossing(slopes: tuple[Array, ...], line: Ints, column: Ints) -> tuple[Array, Array, Array]:
    """Way along the line from a pixel's centre to the ridge [px], curvature across the ridge, normal's cosine, (n,)."""
    x, y, xx, xy, yy = (one[line, column] for one in slopes)
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    curve = mean - np.hypot(half, xy)
    angle = 0.5 * np.arctan2(-2 * xy, -(xx - yy))
    nx, ny = np.cos(angle), np.sin(angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        return -(x * nx + y * ny) / (curve * nx), curve, nx
