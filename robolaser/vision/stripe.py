"""A laser stripe in an image: where its middle lies, in every line of pixels that crosses it."""

from dataclasses import dataclass
from typing import Literal, final

import cv2
import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.vision.board import Image

Axis = Literal["u", "v"]

LEVEL = 0.6
"""Height, from background (0) to peak (1), above which light counts: on the steep flanks, above the halo."""
FOOT = 0.3
"""Height at which a second middle is taken; how far it lies off tells a lopsided profile."""
BACKGROUND_SHARE = 1 / 6
"""Width of the box that blurs the stripe into its background, as a share of the line's length."""
WIDEST_SHARE = 1 / 8
"""Widest stripe, as a share of the line's length; wider light is a lamp or a polished part."""
FAINTEST = 8.0
"""Least height [grey] of a stripe above its blurred surroundings."""
FAINTEST_NOISES = 6.0
"""The same in standard deviations of the image's texture."""
FAINTEST_SHARE = 0.3
"""The same as a share of what is brightest in its line."""
MOST_PER_LINE = 4
"""Candidates kept in one line, the strongest: the stripe, its mirror images, glints."""


@final
@dataclass(frozen=True)
class Centres:
    """Middles of bright runs, several to a line of pixels where light is double.

    Attributes:
        line: Row (column, where the stripe runs along u) of each middle, (n,).
        pixel: The middle, (n, 2) [px] as (u, v).
        width: Between the flanks, (n,) [px].
        light: Grey above the background, summed over the run, (n,).
        peak: Brightest grey of the run, (n,).
        lopsided: Middle near the foot against middle near the top, (n,) [px].
    """

    line: Ints
    pixel: Array
    width: Array
    light: Array
    peak: Array
    lopsided: Array

    def __len__(self) -> int:
        return len(self.line)

    def at(self, kept: Bools | Ints) -> "Centres":
        """Give some of them, by mask or index."""
        return Centres(
            self.line[kept], self.pixel[kept], self.width[kept], self.light[kept], self.peak[kept], self.lopsided[kept]
        )


def stripe_centres(image: Image, axis: Axis) -> Centres:
    """Find every bright run that may be the stripe and the middle of each, to a fraction of a pixel.

    The middle is the centre of mass of what rises above LEVEL. Integrated over heights that is the mean of the
    midpoints between the flanks, so it serves peaks and saturated plateaus alike. Runs cut by the image's
    border have no middle and are left out.

    Args:
        image: Grey image, (height, width).
        axis: Image axis that the stripe runs along: one middle per row for "v", per column for "u".

    Returns:
        The candidates, by line and then by place in the line.
    """
    across = image if axis == "v" else np.asarray(cv2.transpose(image), dtype=np.uint8)
    line, first, last = _runs(across)
    middle, width, light, peak, lopsided = _measure(across, line, first, last)
    pixel = np.stack([middle, line] if axis == "v" else [line, middle], axis=-1)
    return Centres(line, pixel, width, light, peak, lopsided).at(np.isfinite(middle))


def strongest(centres: Centres) -> Centres:
    """Keep one middle to a line, the one with the most light."""
    order = np.lexsort((-centres.light, centres.line))
    _, first = np.unique(centres.line[order], return_index=True)
    return centres.at(order[first])


def _runs(across: Image) -> tuple[Ints, Ints, Ints]:
    """Find bright runs by their line, first and last pixel, each (n,)."""
    lines, length = across.shape
    smooth = cv2.blur(across, (3, 1))
    around = cv2.blur(across, (2 * int(length * BACKGROUND_SHARE / 2) + 1, 1))
    rise = np.asarray(cv2.subtract(smooth, around), dtype=np.uint8)
    texture = 1.4826 * float(np.median(cv2.absdiff(smooth, around)[::4, ::4]))
    top = rise.max(axis=1)
    least = np.maximum(FAINTEST_SHARE * top, max(FAINTEST, FAINTEST_NOISES * texture))
    bright = np.zeros((lines, length + 2), dtype=np.int8)
    bright[:, 1:-1] = rise > least.astype(np.uint8)[:, None]
    edges = np.flatnonzero(np.diff(bright.ravel()))
    line, first = np.divmod(edges[::2], length + 2)
    last = edges[1::2] % (length + 2) - 1
    fits = (last - first >= 1) & (last - first < WIDEST_SHARE * length)
    line, first, last = line[fits], first[fits], last[fits]
    return _fewest(rise, line, first, last)


def _fewest(rise: Image, line: Ints, first: Ints, last: Ints) -> tuple[Ints, Ints, Ints]:
    """Keep the strongest runs of each line."""
    strength = rise[line, (first + last) // 2] * (last - first + 1.0)
    order = np.lexsort((-strength, line))
    ranked = line[order]
    rank = np.arange(len(order)) - np.searchsorted(ranked, ranked)
    kept = np.sort(order[rank < MOST_PER_LINE])
    return line[kept], first[kept], last[kept]


def _measure(across: Image, line: Ints, first: Ints, last: Ints) -> tuple[Array, Array, Array, Array, Array]:
    """Give middle, width, light, peak and lopsidedness of each run, (n,); NaN where the border cuts it."""
    length = across.shape[1]
    reach = int((last - first).max(initial=0)) // 2 + 12
    centre = (first + last) // 2
    column = centre[:, None] + np.arange(-reach, reach + 1)
    grey = across[line[:, None], np.clip(column, 0, length - 1)].astype(np.float64)
    grey[(column < 0) | (column >= length)] = np.inf
    own = (column >= first[:, None]) & (column <= last[:, None])
    peak = np.where(own, grey, 0.0).max(axis=1)
    brightest = own & (grey == peak[:, None])
    seat = (brightest.argmax(axis=1) + 2 * reach - brightest[:, ::-1].argmax(axis=1)) // 2
    margin = 3 + (last - first) // 4
    ground = 0.5 * (_grey_at(across, line, first - margin) + _grey_at(across, line, last + margin))
    middle, width, light = _mass_above(ground + LEVEL * (peak - ground), grey, seat)
    foot, _, _ = _mass_above(ground + FOOT * (peak - ground), grey, seat)
    return centre - reach + middle, width, light, peak, foot - middle


def _grey_at(across: Image, line: Ints, column: Ints) -> Array:
    nearby = np.clip(column[:, None] + np.arange(-1, 2), 0, across.shape[1] - 1)
    return np.asarray(across[line[:, None], nearby].mean(axis=1, dtype=np.float64))


def _mass_above(level: Array, grey: Array, seat: Ints) -> tuple[Array, Array, Array]:
    """Integrate the profile, straight between pixels, from flank to flank where it crosses the level.

    Args:
        level: Height, (n,) [grey].
        grey: Profiles, infinite outside the image, (n, m).
        seat: Index of a pixel inside the run, (n,).

    Returns:
        Centre of mass, width between the flanks, and area, (n,); NaN where a flank is missing.
    """
    n, m = grey.shape
    index, row = np.arange(m), np.arange(n)
    below = grey <= level[:, None]
    before = np.where(below & (index < seat[:, None]), index, -1).max(axis=1, initial=-1)
    after = np.where(below & (index > seat[:, None]), index, m).min(axis=1, initial=m)
    whole = (before >= 0) & (after < m) & (grey[row, seat] > level)
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
    return moment / area, np.where(whole, tail - head + to_head + to_tail, np.nan), area
