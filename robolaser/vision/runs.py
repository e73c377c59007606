"""Bright runs: the pixels next to each other in one line that a stripe may have lit."""

from dataclasses import dataclass
from typing import Any, final

import cv2
import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.geometry.mad_scale import mad_scale
from robolaser.vision.board import Image

BACKGROUND_SHARE = 1 / 6  # width of the box that blurs the stripe into its background, as a share of the line's length
WIDEST_SHARE = 1 / 8  # widest stripe, as a share of the line's length; wider light is a lamp or a polished part
FAINTEST = 8.0  # least height [grey] of a stripe above its blurred surroundings
FAINTEST_NOISES = 6.0  # the same in standard deviations of the image's texture
FAINTEST_SHARE = 0.3  # the same as a share of what is brightest in its line
MOST_PER_LINE = 4  # candidates kept in one line, the strongest: the stripe, its mirror images, glints
ROUNDING = 0.29  # noise [grey] that whole numbers bring, 1/√12: no image has less
LEAST_NOISE = 1e-3  # the same of grey with fractions: a thousandth of a camera's sixteen bits
NOISE_EVERY = 8  # lines of pixels from one that is asked for the noise to the next
ONE_SIGMA = 0.6827  # share of a Gaussian within one standard deviation


@final
@dataclass(frozen=True)
class Runs:
    """Runs in an image's lines."""

    across: Image  # the image, turned so that the lines that cross the stripe are its rows, (lines, length)
    line: Ints  # line of each run, ascending, (n,)
    first: Ints  # its first pixel, ascending within a line, (n,)
    last: Ints  # its last pixel, (n,)
    noise: float  # standard deviation of a pixel [grey]

    def __len__(self) -> int:
        return len(self.line)

    def room(self) -> tuple[Ints, Ints]:
        """First and last pixel of each line that belong to no other run, as far as the image goes, (n,) each."""
        alone = np.diff(self.line) != 0
        before, after = np.zeros_like(self.first), np.full_like(self.last, self.across.shape[1] - 1)
        before[1:] = np.where(alone, 0, self.last[:-1] + 1)
        after[:-1] = np.where(alone, self.across.shape[1] - 1, self.first[1:] - 1)
        return before, after


def find_runs(across: Image) -> Runs:
    """Find what is brighter than its surroundings, narrow enough for a stripe, and strong in its line."""
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
    kept = _strongest(rise, line, first, last)
    return Runs(across, line[kept], first[kept], last[kept], _noise(across))


def _strongest(rise: Image, line: Ints, first: Ints, last: Ints) -> Ints:
    """Choose the strongest runs of each line, (k,)."""
    if np.bincount(line).max(initial=0) <= MOST_PER_LINE:
        return np.arange(len(line))
    strength = rise[line, (first + last) // 2] * (last - first + 1.0)
    order = np.lexsort((-strength, line))
    ranked = line[order]
    rank = np.arange(len(order)) - np.searchsorted(ranked, ranked)
    return np.sort(order[rank < MOST_PER_LINE])


def _noise(across: Image) -> float:
    """Standard deviation of a pixel as second differences along some lines tell it [grey]."""
    whole = across.dtype == np.uint8
    some: Any = across[NOISE_EVERY // 2 :: NOISE_EVERY].astype(np.int16 if whole else np.float32)
    curve = np.abs(some[:, 2:] - 2 * some[:, 1:-1] + some[:, :-2])
    if not whole:
        return max(float(np.quantile(curve, ONE_SIGMA)) / float(np.sqrt(6.0)), LEAST_NOISE)
    share = np.cumsum(np.bincount(curve.ravel(), minlength=1)) / max(curve.size, 1)
    ends = np.append(0.0, np.arange(len(share)) + 0.5)
    within = float(np.interp(ONE_SIGMA, np.append(0.0, share), ends))
    return max(within / float(np.sqrt(6.0)), ROUNDING)


def grey_at(runs: Runs, column: Ints) -> Array:
    """Mean grey of three pixels of each run's line about a column, (n,)."""
    nearby = np.clip(column[:, None] + np.arange(-1, 2), 0, runs.across.shape[1] - 1)
    return np.asarray(runs.across[runs.line[:, None], nearby].mean(axis=1, dtype=np.float64))
