"""The course of one stripe through any image: the bright runs that belong to it, and those of its mirror images."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.geometry.mad_scale import mad_scale
from robolaser.vision.runs import LineCentres, best_of_each

STEEPEST = 3.0  # from one line of pixels to the next [px]; more is a step in depth, or another light
MISSING = 2  # lines without light that a piece of a stripe bridges
SHORTEST = 6  # least lines of a piece of a stripe: glints and noise are shorter
WINNING = 0.5
"""Least share of a piece's lines in which it is the strongest light; a mirror image is alone only where the stripe is
hidden."""
BREADTHS = (1 / 3, 3.0)  # range of a stripe's width over the typical one
ROUGHEST_PX = 0.7  # mean distance of a piece's centres from their neighbours' prediction; more is texture
MOST_JUMP_PX = 3.0  # largest distance [px] that a centre contributes to that mean
BESIDE = 5  # lines on either side that predict a centre
STRAY_SIGMAS = 5.0  # distance from the prediction, in the stripe's standard deviations, of an outlier
STRAY_LEAST_PX = 0.3  # least such distance [px]: surfaces are not smooth
OF_JUMP = 1.08  # scatter of a centre less the median of five pairs around it, over its own scatter


def track_stripe(centres: LineCentres) -> tuple[Bools, float]:
    """Choose the centres of one stripe among the candidates of an image (n), by line, one at most in each.

    Light that continues from line to line forms pieces; steps in depth, edges and gaps end them. Of pieces side by side
    the one with more light is chosen, longer ones before shorter.

    Returns:
        Whether each candidate is chosen, (n,), and the ratio of their scatter along the stripe to their stated standard
        deviation, at least 1.
    """
    at = np.flatnonzero(_fitting(centres))
    chosen = np.zeros(len(centres), dtype=np.bool_)
    if len(at) == 0:
        return chosen, 1.0
    line, x = centres.line[at], centres.centre[at]
    piece = pieces(line, x)
    count = np.bincount(piece)
    score = (np.bincount(piece, centres.light[at]) / np.sqrt(count))[piece]
    wins = best_of_each(line, score)
    won = np.bincount(piece, wins)
    kept = wins & ((count >= SHORTEST) & (won >= WINNING * count))[piece]
    at, piece = at[kept], piece[kept]
    jump = _jumps(centres.line[at], centres.centre[at], piece)
    rough = np.bincount(piece, np.minimum(np.nan_to_num(np.abs(jump)), MOST_JUMP_PX), len(count))
    calm = (rough <= ROUGHEST_PX * won)[piece]
    at, jump = at[calm], jump[calm]
    relative = jump / (OF_JUMP * centres.std[at])
    excess = max(1.0, mad_scale(relative[np.isfinite(relative)])) if np.isfinite(relative).any() else 1.0
    stray = np.abs(jump) > np.maximum(STRAY_SIGMAS * excess * OF_JUMP * centres.std[at], STRAY_LEAST_PX)
    chosen[at[~stray & ~_next_to_step(piece[calm])]] = True
    return chosen, excess


def _next_to_step(piece: Ints) -> Bools:
    """Whether a centre, by line, is next to one of another piece: there, a pixel sees both surfaces."""
    is_next = np.zeros(len(piece), dtype=np.bool_)
    change = piece[1:] != piece[:-1]
    is_next[1:] |= change
    is_next[:-1] |= change
    return is_next


def _fitting(centres: LineCentres) -> Bools:
    """Whether each run is symmetric, and about as wide as those with most light."""
    width, order = centres.width, np.argsort(centres.width)
    heavy = np.cumsum(centres.light[order])
    if len(heavy) == 0:
        return np.zeros(0, dtype=np.bool_)
    least, most = np.array(BREADTHS) * width[order[np.searchsorted(heavy, 0.5 * heavy[-1])]]
    return np.asarray(centres.is_symmetric & (width >= least) & (width <= most))


def pieces(line: Ints, x: Array) -> Ints:
    """Number the pieces of runs, (n,), by their ascending lines, (n,), and positions in these, (n,) [px].

    Each continues in the nearest run of the next line, if that is mutual.
    """
    n = len(line)
    slot = np.arange(n) - np.searchsorted(line, line)
    seat = np.full((int(line.max()) + 1, int(slot.max()) + 1), -1)
    seat[line, slot] = np.arange(n)
    before, free = np.arange(n), np.ones(n, dtype=np.bool_)
    for gap in range(1, 2 + MISSING):
        here, there = seat[:-gap], seat[gap:]
        ends, starts = (here >= 0) & free[here], (there >= 0) & (before[there] == there)
        apart = np.abs(x[there][:, None, :] - x[here][:, :, None])
        apart[~(ends[:, :, None] & starts[:, None, :])] = np.inf
        row, nearest = np.arange(len(here))[:, None], apart.argmin(axis=2)
        back = apart.argmin(axis=1)
        agree = (back[row, nearest] == np.arange(here.shape[1])) & (apart.min(axis=2) <= STEEPEST * gap)
        end = here[agree]
        before[there[row, nearest][agree]] = end
        free[end] = False
    while not np.array_equal(before, before[before]):
        before = before[before]
    return np.unique(before, return_inverse=True)[1].astype(np.int64)


def _jumps(line: Ints, x: Array, piece: Ints) -> Array:
    """Distance of each centre from its prediction by pairs on either side, (n,) [px]; NaN where it has none."""
    n = len(line)
    seen = np.full((BESIDE, n), np.nan)
    for k in range(1, BESIDE + 1):
        if n <= 2 * k:
            break
        left, right, here = slice(None, -2 * k), slice(2 * k, None), slice(k, -k)
        pair = (piece[left] == piece[here]) & (piece[right] == piece[here])
        pair &= line[right] - line[here] == line[here] - line[left]
        seen[k - 1, here] = np.where(pair, 0.5 * (x[left] + x[right]), np.nan)
    seen.sort(axis=0)
    count = np.isfinite(seen).sum(axis=0)
    every = np.arange(n)
    return np.asarray(x - 0.5 * (seen[np.maximum(count - 1, 0) // 2, every] + seen[count // 2, every]))
