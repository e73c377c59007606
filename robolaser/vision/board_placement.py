"""The part of a stripe on the board's plane: there, and only there, it is straight."""

import numpy as np
from scipy.ndimage import median_filter

from robolaser.arrays import Array, Bools, Ints
from robolaser.geometry.mad_scale import mad_scale
from robolaser.vision.runs import LineCentres, best_of_each

STRATA = 20  # parts of the image; trial lines go through line centres in them
WIDEST_GATE_PX = 3.0  # largest distance of an inlier, also of a trial line, however much the board bows
NARROWEST_GATE_PX = 1.0  # distance [px] of a certain inlier: no board is perfectly flat
GATE_SIGMAS = 3.0  # the same in standard deviations of the inliers
JUMP_LEAST_PX = 0.1  # distance from the neighbours' median [px] that is always allowed
JUMP_SIGMAS = 4.0  # the same in standard deviations of the centre
NEIGHBOURS = 15  # lines of pixels on either side that show whether the stripe is straight
LEAST_SUPPORT = 0.5  # share of these that must agree: a stripe on another surface crosses the line only briefly
CHANGE_SPAN = 10  # lines of pixels on either side for a comparison of the stripe's width
MOST_CHANGE = 0.12  # relative change of width between them; more is a square's edge or a shadow
ROUNDS = 6  # largest number of fits, each to the centres near the previous line; two are usually enough
APART = 0.8  # least distance of two centres on a trial line, in lengths of a part: nearer ones give no slope
JURY = 200  # centres that a trial line is tested on, if there are as many


STEP_LEAST_PX = 0.3  # largest step of a stripe on the board, beside the squares: about 0.2 mm of height
STEP_SIGMAS = 5.0  # the same in standard deviations of the difference of two medians
FEWEST_LINES = 20  # least lines of pixels with the stripe on the board for a straight line


def on_plane(
    centres: LineCentres, along: Array, across: Array, nearness: Array, on_squares: Bools
) -> tuple[Bools, Array]:
    """Select the centres on one straight line, one at most in each line of pixels.

    Where the stripe crosses the board's squares the line is fitted there, and continues beside them up to a step: there
    the board ends, and the stripe is on the table below it.

    Args:
        centres: The candidates of an image.
        along: Their coordinate along the stripe, without the lens's distortion, (n,) [px].
        across: The other coordinate, (n,) [px].
        nearness: Weight of each, (n,): a stripe near the board is more likely on its plane than one far off.
        on_squares: Whether each is among the board's squares, (n,).

    Returns:
        Whether each candidate is kept, (n,), and its distance from the line, (n,) [px].
    """
    if len(along) < 2:
        return np.zeros(len(along), dtype=np.bool_), np.zeros(len(along))
    usable = centres.is_symmetric
    if crosses_squares(centres, on_squares):
        off, _ = _from_line(along, across, np.where(usable & on_squares, nearness, 0.0))
        near = _nearest(centres.line, np.abs(off), usable & (np.abs(off) <= 2 * WIDEST_GATE_PX))
        first, last = _up_to_a_step(centres.line, off, _undisturbed(centres, off, near), on_squares)
        usable = usable & (centres.line >= first) & (centres.line <= last)
    off, gate = _from_line(along, across, np.where(usable, nearness, 0.0))
    kept = _nearest(centres.line, np.abs(off), usable & (np.abs(off) <= WIDEST_GATE_PX))
    kept = _undisturbed(centres, off, kept) & (np.abs(off) <= gate)
    return kept & _supported(centres.line, kept), off


def crosses_squares(centres: LineCentres, on_squares: Bools) -> bool:
    """Whether enough lines of pixels show the stripe among the board's squares."""
    return len(np.unique(centres.line[centres.is_symmetric & on_squares])) >= FEWEST_LINES


def _from_line(along: Array, across: Array, weight: Array) -> tuple[Array, float]:
    """Distance of each centre from the likeliest straight line, (n,), and the gate for inliers [px]."""
    off = _distance(along, across, *_likeliest(along, across, weight))
    gate = WIDEST_GATE_PX
    for _ in range(ROUNDS):
        kept = (weight > 0) & (np.abs(off) <= gate)
        if kept.sum() < 2:
            return off, -1.0
        off = _distance(along, across, *np.polyfit(along[kept], across[kept], 1))
        gate = float(np.clip(GATE_SIGMAS * mad_scale(off[kept]), NARROWEST_GATE_PX, WIDEST_GATE_PX))
    return off, gate


def _up_to_a_step(line: Ints, off: Array, kept: Bools, on_squares: Bools) -> tuple[int, int]:
    """First and last line of pixels between which the stripe continues from the board's squares without a step."""
    at = np.flatnonzero(kept)
    inside = np.flatnonzero(on_squares[at])
    if len(inside) < FEWEST_LINES:
        return int(line.min()), int(line.max())
    medians = np.median(np.lib.stride_tricks.sliding_window_view(off[at], NEIGHBOURS), axis=-1)
    step = np.abs(medians[NEIGHBOURS:] - medians[:-NEIGHBOURS])  # between `at` i - 1 and i for i from NEIGHBOURS on
    sigma = mad_scale(jumps(off[at])) * np.sqrt(np.pi / NEIGHBOURS)
    steps = NEIGHBOURS + np.flatnonzero(step > max(STEP_LEAST_PX, STEP_SIGMAS * sigma))
    before, after = steps[steps <= inside[0] + NEIGHBOURS // 2], steps[steps > inside[-1] - NEIGHBOURS // 2]
    first = before.max(initial=0)
    last = after.min(initial=len(at)) - 1
    return int(line[at[first]]), int(line[at[last]])


def jumps(off: Array) -> Array:
    """Distance of each centre from the line, (n,), less the median of its neighbours': noise without bow."""
    return off - np.asarray(median_filter(off, 2 * NEIGHBOURS + 1, mode="nearest"), dtype=np.float64)


def _distance(along: Array, across: Array, slope: float, start: float) -> Array:
    return np.asarray((across - slope * along - start) / np.hypot(1.0, slope))


def _likeliest(along: Array, across: Array, weight: Array) -> tuple[float, float]:
    """Slope and start of the line with the most weight near it, among lines through pairs of candidates."""
    able = np.flatnonzero(weight > 0)
    if len(able) < 2:
        return 0.0, float(np.median(across))
    low, high = along[able].min(), along[able].max()
    part = np.floor((along[able] - low) / max(high - low, 1e-9) * STRATA * (1 - 1e-9)).astype(np.int64)
    posts = []
    for k in np.unique(part):
        members = able[part == k]
        row = along[members[len(members) // 2]]
        posts.append(members[np.abs(along[members] - row) < 1.0])
    post = np.concatenate(posts)
    i, j = np.triu_indices(len(post), k=1)
    i, j = post[i], post[j]
    apart = np.abs(along[j] - along[i]) >= APART * (high - low) / STRATA
    i, j = i[apart], j[apart]
    if len(i) == 0:
        return 0.0, float(np.median(across[able]))
    slope = (across[j] - across[i]) / (along[j] - along[i])
    start = across[i] - slope * along[i]
    jury = able[:: max(1, len(able) // JURY)]
    off = np.abs(across[jury] - slope[:, None] * along[jury] - start[:, None])
    votes = (off <= WIDEST_GATE_PX * np.hypot(1.0, slope)[:, None]) @ weight[jury]
    best = int(np.argmax(votes))
    return float(slope[best]), float(start[best])


def _nearest(line: Ints, distance: Array, able: Bools) -> Bools:
    """Keep the candidate nearest to the straight line in each line of pixels."""
    return best_of_each(line, np.where(able, -distance, -np.inf)) & able


def _undisturbed(centres: LineCentres, off: Array, kept: Bools) -> Bools:
    """Drop centres that jump against their neighbours, or where the stripe's width changes."""
    at = np.flatnonzero(kept)
    if len(at) <= 2 * NEIGHBOURS:
        return kept
    width = np.log(median_filter(centres.width[at], 5))
    change = np.abs(np.roll(width, -CHANGE_SPAN) - np.roll(width, CHANGE_SPAN))
    change[:CHANGE_SPAN] = np.abs(width[:CHANGE_SPAN] - width[CHANGE_SPAN : 2 * CHANGE_SPAN])
    change[-CHANGE_SPAN:] = np.abs(width[-CHANGE_SPAN:] - width[-2 * CHANGE_SPAN : -CHANGE_SPAN])
    jump = jumps(off[at])
    calm = (change <= MOST_CHANGE) & (np.abs(jump) <= max(JUMP_SIGMAS * mad_scale(jump), JUMP_LEAST_PX))
    result = np.zeros(len(kept), dtype=np.bool_)
    result[at[calm]] = True
    return result


def _supported(line: Ints, kept: Bools) -> Bools:
    """Whether most lit lines of pixels around each candidate have light on the straight line."""
    height = int(line.max()) + 1
    lit, good = np.zeros(height), np.zeros(height)
    lit[line] = 1.0
    good[line[kept]] = 1.0
    window = np.ones(2 * NEIGHBOURS + 1)
    share = np.convolve(good, window, mode="same") / np.maximum(np.convolve(lit, window, mode="same"), 1.0)
    return np.asarray(share[line] >= LEAST_SUPPORT)
