"""Bright runs, adjacent pixels in one line that a stripe may have lit, and the profile of each."""

from dataclasses import dataclass, fields, replace
from typing import Any, Literal, final

import cv2
import numpy as np

from robolaser.arrays import Array, Bools, Image, Ints
from robolaser.geometry.mad_scale import mad_scale

ImageAxis = Literal["u", "v"]
BACKGROUND_SHARE = 1 / 6  # width of the box filter for the background, as a share of the line's length
WIDEST_SHARE = 1 / 8  # widest stripe, as a share of the line's length; wider light is a lamp or a polished part
FAINTEST = 8.0  # least height [grey] of a stripe above its blurred surroundings
FAINTEST_NOISES = 6.0  # the same in standard deviations of the image's texture
FAINTEST_SHARE = 0.3  # the same as a share of the brightest pixel in its line
MOST_PER_LINE = 4  # candidates kept in one line, the strongest: the stripe, its mirror images, glints
ROUNDING = 0.29  # noise [grey] of whole numbers, 1/√12: no image has less
LEAST_NOISE = 1e-3  # the same of grey with fractions: a thousandth of a camera's sixteen bits
NOISE_EVERY = 8  # spacing of the lines of pixels that the noise is estimated from
ONE_SIGMA = 0.6827  # share of a Gaussian within one standard deviation
FULL = 255  # grey of a saturated pixel: its light was at least as bright
LEVEL = 0.6  # height, from background (0) to peak (1), above which light counts: on the steep flanks, above the halo
FOOT = 0.3  # height for a second centre; its distance from the first shows an asymmetric profile
LEAST_SECOND_MOMENT = 0.1  # sum of squared distances of pixels from the centre [px²], at least
MOST_ASYMMETRY = 0.15  # largest shift from foot to top of a stripe's profile, as a share of the width
FLANK_PX = 0.05  # of a saturated centre beside noise [px]: its steep flanks are not linear between pixels


@final
@dataclass(frozen=True)
class BrightRuns:
    """Runs in an image's lines."""

    axis: ImageAxis  # image axis that the stripe runs along
    across: Image  # the image, turned so that the lines that cross the stripe are its rows, (lines, length)
    line: Ints  # line of each run, ascending, (n,)
    first: Ints  # its first pixel, ascending within a line, (n,)
    last: Ints  # its last pixel, (n,)
    noise: float  # standard deviation of a pixel [grey]

    def room(self) -> tuple[Ints, Ints]:
        """First and last pixel around each run that belong to no other one, within the image, (n,) each."""
        alone = np.diff(self.line) != 0
        before, after = np.zeros_like(self.first), np.full_like(self.last, self.across.shape[1] - 1)
        before[1:] = np.where(alone, 0, self.last[:-1] + 1)
        after[:-1] = np.where(alone, self.across.shape[1] - 1, self.first[1:] - 1)
        return before, after


def find_runs(image: Image, axis: ImageAxis) -> BrightRuns:
    """Find runs that are brighter than their surroundings, narrow enough for a stripe, and strong in their line."""
    across = image if axis == "v" else np.asarray(cv2.transpose(image), dtype=image.dtype)
    length = across.shape[1]
    smooth = cv2.blur(across, (3, 1))
    around = cv2.blur(across, (2 * int(length * BACKGROUND_SHARE / 2) + 1, 1))
    rise = np.asarray(np.maximum(cv2.subtract(smooth, around), 0), dtype=across.dtype)
    texture = mad_scale(np.asarray(cv2.absdiff(smooth, around)[::4, ::4]))
    top = rise.max(axis=1)
    least = np.maximum(FAINTEST_SHARE * top.astype(np.float64), max(FAINTEST, FAINTEST_NOISES * texture))
    bright = np.zeros((across.shape[0], length + 2), dtype=np.bool_)
    np.greater(rise, least.astype(across.dtype)[:, None], out=bright[:, 1:-1])
    flat = bright.ravel()
    edges = np.flatnonzero(flat[1:] != flat[:-1])
    line, first = np.divmod(edges[::2], length + 2)
    last = edges[1::2] % (length + 2) - 1
    fits = (last - first >= 1) & (last - first < WIDEST_SHARE * length)
    line, first, last = line[fits], first[fits], last[fits]
    kept = best_of_each(line, rise[line, (first + last) // 2] * (last - first + 1.0), MOST_PER_LINE)
    return BrightRuns(axis, across, line[kept], first[kept], last[kept], _noise(across))


def best_of_each(line: Ints, worth: Array, most: int = 1) -> Bools:
    """Whether each of n items is among the best in its line, (n,), by its score, (n,)."""
    order = np.lexsort((-worth, line))
    ranked, best = line[order], np.zeros(len(line), dtype=np.bool_)
    best[order[np.arange(len(line)) - np.searchsorted(ranked, ranked) < most]] = True
    return best


def _noise(across: Image) -> float:
    """Standard deviation of a pixel by second differences along some lines [grey]."""
    whole = across.dtype == np.uint8
    some: Any = across[NOISE_EVERY // 2 :: NOISE_EVERY].astype(np.int16 if whole else np.float32)
    curve = np.abs(some[:, 2:] - 2 * some[:, 1:-1] + some[:, :-2])
    if not whole:
        return max(float(np.quantile(curve, ONE_SIGMA)) / float(np.sqrt(6.0)), LEAST_NOISE)
    share = np.cumsum(np.bincount(curve.ravel(), minlength=1)) / max(curve.size, 1)
    ends = np.append(0.0, np.arange(len(share)) + 0.5)
    within = float(np.interp(ONE_SIGMA, np.append(0.0, share), ends))
    return max(within / float(np.sqrt(6.0)), ROUNDING)


@final
@dataclass(frozen=True)
class LineCentres:
    """Centres of bright runs, several to a line of pixels where light is double."""

    axis: ImageAxis  # image axis that the stripe runs along
    line: Ints  # row (column, where the stripe runs along u) of each centre, (n,)
    centre: Array  # the centre in its line of pixels, (n,) [px]; NaN where the image's border cuts the run
    std: Array  # its standard deviation by the image's noise, (n,) [px]
    width: Array  # between the flanks at LEVEL, (n,) [px]
    foot: Array  # between the flanks at FOOT, (n,) [px]
    light: Array  # grey above LEVEL, summed over the run, (n,)
    peak: Array  # brightest grey of the run, (n,)
    ground: Array  # grey beside the run, (n,)
    full: Ints  # saturated pixels, (n,)
    asymmetry: Array  # middle above FOOT against centre above LEVEL, (n,) [px]

    def __len__(self) -> int:
        return len(self.line)

    @property
    def pixel(self) -> Array:
        """The centres, (n, 2) [px] as (u, v)."""
        return np.stack([self.centre, self.line] if self.axis == "v" else [self.line, self.centre], axis=-1)

    @property
    def is_symmetric(self) -> Bools:
        """Whether each profile is as symmetric as a stripe's, (n,)."""
        return np.asarray(np.abs(self.asymmetry) <= MOST_ASYMMETRY * self.width)

    def at(self, kept: Bools | Ints) -> "LineCentres":
        """Select centres by mask or index."""
        return replace(self, **{one.name: getattr(self, one.name)[kept] for one in fields(self) if one.name != "axis"})


def measure(runs: BrightRuns) -> LineCentres:
    """Measure each run's profile; its centre is the centre of gravity above LEVEL.

    Integrated over heights, the centre of gravity above a level is the mean of the midpoints between the flanks: it is
    valid for peaks and saturated plateaus.
    """
    before, after = runs.room()
    margin = 3 + (runs.last - runs.first) // 4
    left = np.maximum(runs.first - margin, (before + runs.first) // 2)
    right = np.minimum(runs.last + margin, (after + runs.last + 1) // 2)
    ground = 0.5 * (_grey_at(runs, left) + _grey_at(runs, right))
    reach = int((runs.last - runs.first).max(initial=0)) // 2 + 12
    grey, middle, peak, peak_column, full = _cut_out(runs, reach)
    centre, width, light, moment_2 = _above_level(ground + LEVEL * (peak - ground), grey, peak_column)
    low, foot, _, _ = _above_level(ground + FOOT * (peak - ground), grey, peak_column)
    std = np.hypot(runs.noise * np.sqrt(moment_2) / light, np.where(full > 0, FLANK_PX, 0.0))
    return LineCentres(
        runs.axis, runs.line, middle - reach + centre, std, width, foot, light, peak, ground, full, low - centre
    )


def _cut_out(runs: BrightRuns, reach: int) -> tuple[Array, Ints, Array, Ints, Ints]:
    """Each run's pixels and `reach` more on either side of its middle.

    Returns:
        Grey, infinite outside the image, (n, 2 reach + 1); the middle's column in the image, (n,); the run's brightest
        grey, its index in the first array, and the number of the run's saturated pixels, (n,).
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
    """Integrate profiles, (n, m), linear between pixels, from flank to flank where they cross a level, (n,).

    They are infinite outside the image; the peak's column, (n,), is inside the run.

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


def _grey_at(runs: BrightRuns, column: Ints) -> Array:
    """Mean grey of three pixels of each run's line about a column, (n,)."""
    nearby = np.clip(column[:, None] + np.arange(-1, 2), 0, runs.across.shape[1] - 1)
    return np.asarray(runs.across[runs.line[:, None], nearby].mean(axis=1, dtype=np.float64))
