"""Profiles of a stripe: their centres of gravity above a level, their widths and their light."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.vision.runs import Runs, grey_at

FULL = 255  # grey of a saturated pixel: it was at least as bright
LEVEL = 0.6  # height, from background (0) to peak (1), above which light counts: on the steep flanks, above the halo
FOOT = 0.3  # height at which a second centre is taken; its distance from the other shows an asymmetric profile
LEAST_SECOND_MOMENT = 0.1  # sum of squared distances of pixels from the centre [px²], at least
FLANK_PX = 0.05
"""Error [px] of a saturated centre beside the noise's: its flanks are steep, and no line goes from pixel to pixel."""


@final
@dataclass(frozen=True)
class Profiles:
    """What the lines' pixels say of each run (n); NaN where the image's border cuts it."""

    centre: Array  # centre of gravity above LEVEL, (n,) [px along the line]
    std: Array  # its standard deviation, (n,) [px]
    width: Array  # between the flanks at LEVEL, (n,) [px]
    foot: Array  # between the flanks at FOOT, (n,) [px]
    light: Array  # grey above LEVEL, summed, (n,)
    peak: Array  # brightest grey, (n,)
    ground: Array  # grey beside the run, (n,)
    full: Ints  # saturated pixels, (n,)
    asymmetry: Array  # middle above FOOT against centre above LEVEL, (n,) [px]


def measure(runs: Runs) -> Profiles:
    """Measure each run's profile.

    Integrated over heights, the centre of gravity above a level is the mean of the midpoints between the flanks, so it
    serves peaks and saturated plateaus alike.
    """
    before, after = runs.room()
    margin = 3 + (runs.last - runs.first) // 4
    left = np.maximum(runs.first - margin, (before + runs.first) // 2)
    right = np.minimum(runs.last + margin, (after + runs.last + 1) // 2)
    ground = 0.5 * (grey_at(runs, left) + grey_at(runs, right))
    reach = int((runs.last - runs.first).max(initial=0)) // 2 + 12
    grey, middle, peak, peak_column, full = _cut_out(runs, reach)
    centre, width, light, moment_2 = _above_level(ground + LEVEL * (peak - ground), grey, peak_column)
    low, foot, _, _ = _above_level(ground + FOOT * (peak - ground), grey, peak_column)
    std = np.hypot(runs.noise * np.sqrt(moment_2) / light, np.where(full > 0, FLANK_PX, 0.0))
    return Profiles(middle - reach + centre, std, width, foot, light, peak, ground, full, low - centre)


def _cut_out(runs: Runs, reach: int) -> tuple[Array, Ints, Array, Ints, Ints]:
    """Each run's pixels and `reach` more on either side of its middle.

    Returns:
        Grey, infinite outside the image, (n, 2 reach + 1); the middle's column in the image, (n,); the run's brightest
        grey, where it is in the first array, and how many of the run's pixels are saturated, (n,).
    """
    length = runs.across.shape[1]
    middle = (runs.first + runs.last) // 2
    column = middle[:, None] + np.arange(-reach, reach + 1)
    grey = runs.across[runs.line[:, None], np.clip(column, 0, length - 1)].astype(np.float64)
    grey[(column < 0) | (column >= length)] = np.inf
    own = (column >= runs.first[:, None]) & (column <= runs.last[:, None])
    peak = np.where(own, grey, 0.0).max(axis=1)
    brightest = own & (grey == peak[:, None])
    peak_column = (brightest.argmax(axis=1) + 2 * reach - brightest[:, ::-1].argmax(axis=1)) // 2
    return grey, middle, peak, peak_column, (own & (grey == FULL)).sum(axis=1)


def _above_level(level: Array, grey: Array, peak_column: Ints) -> tuple[Array, Array, Array, Array]:
    """Integrate the profile, straight between pixels, from flank to flank where it crosses the level.

    Args:
        level: Height, (n,) [grey].
        grey: Profiles, infinite outside the image, (n, m).
        peak_column: Index of a pixel inside the run, (n,).

    Returns:
        Centre of gravity, width between the flanks, area, and squared distance from the centre summed over the pixels
        that are not saturated, (n,); NaN where a flank is missing.
    """
    n, m = grey.shape
    index, row = np.arange(m), np.arange(n)
    below = grey <= level[:, None]
    before = np.where(below & (index < peak_column[:, None]), index, -1).max(axis=1, initial=-1)
    after = np.where(below & (index > peak_column[:, None]), index, m).min(axis=1, initial=m)
    whole = (before >= 0) & (after < m) & (grey[row, peak_column] > level)
    before, after = np.where(whole, before, 0), np.where(whole, after, m - 1)
    inside = whole[:, None] & (index > before[:, None]) & (index < after[:, None])
    a = np.where(inside, grey, level[:, None]) - level[:, None]
    head, tail = before + 1, after - 1
    a_head, a_tail = np.where(whole, a[row, head], 1.0), np.where(whole, a[row, tail], 1.0)
    to_head = a_head / (a_head + np.where(whole, level - grey[row, before], 1.0))
    to_tail = a_tail / (a_tail + np.where(whole, level - grey[row, after], 1.0))
    area = a.sum(axis=1) - 0.5 * (a_head * (1 - to_head) + a_tail * (1 - to_tail))
    moment = a @ index - a_head * (head / 2 - 1 / 4) - a_tail * (tail / 2 + 1 / 4) + (a_tail - a_head) / 12
    moment += 0.5 * (a_head * to_head * (head - to_head / 3) + a_tail * to_tail * (tail + to_tail / 3))
    area = np.where(whole, area, np.nan)
    centre = moment / area
    moments = np.where(inside & (grey < FULL), (index - centre[:, None]) ** 2, 0.0).sum(axis=1)
    moments -= np.where(a_head < FULL - level, (0.75 - 0.25 * to_head * (2 + to_head)) * (head - centre) ** 2, 0.0)
    moments -= np.where(a_tail < FULL - level, (0.75 - 0.25 * to_tail * (2 + to_tail)) * (tail - centre) ** 2, 0.0)
    moments = np.maximum(moments, LEAST_SECOND_MOMENT)
    return centre, np.where(whole, tail - head + to_head + to_tail, np.nan), area, moments
