"""The part of a stripe that lies on the board's plane: there, and only there, it is straight."""

import numpy as np
from scipy.ndimage import median_filter

from robolaser.arrays import Array, Bools, Ints
from robolaser.geometry.mad_scale import mad_scale
from robolaser.vision.runs import LineCentres, best_of_each

STRATA = 20  # lines tried are drawn through centres in this many parts of the image
WIDEST_GATE_PX = 3.0  # beyond, no centre is kept, however much the board bows, nor speaks for a line that is tried
NARROWEST_GATE_PX = 1.0  # distance [px] within which a centre is always kept: no board is perfectly flat
GATE_SIGMAS = 3.0  # the same in standard deviations of the centres kept
JUMP_LEAST_PX = 0.1  # distance from the neighbours' median [px] that no centre is dropped for
JUMP_SIGMAS = 4.0  # from the neighbours' median, in its own standard deviations, beyond which a centre is a stray
NEIGHBOURS = 15  # lines of pixels on either side that are asked whether the stripe is straight here
LEAST_SUPPORT = 0.5  # share of those that must agree: a stripe on something else crosses the straight line only briefly
CHANGE_SPAN = 10  # lines of pixels on either side between which the stripe's width is compared
MOST_CHANGE = 0.12  # relative, of width between them, beyond which a square's edge or a shadow bites into the stripe
ROUNDS = 6  # fits of the straight line at most, each to the centres near the one before; mostly two settle it
APART = 0.8  # two centres that a line is tried through, at least, in the parts' lengths: nearer ones tell no slope
JURY = 200  # centres that judge a line, at least, where there are as many: more tell no more


STEP_LEAST_PX = 0.3  # of the stripe beside the squares, up to which it lies on the board: 0.2 mm of height or so
STEP_SIGMAS = 5.0  # the same in standard deviations of the difference of two medians
FEWEST_LINES = 20  # lines of pixels that must show the stripe on the board, for a straight line to mean something


def on_plane(
    centres: LineCentres, along: Array, across: Array, nearness: Array, on_squares: Bools
) -> tuple[Bools, Array]:
    """Pick the centres that lie on one straight line, one at most in each line of pixels.

    Where the stripe crosses the board's squares the line is theirs, and goes on beside them up to a step: there the
    board ends, and the stripe lies on the table below it.

    Args:
        centres: The candidates of an image.
        along: Their coordinate along the stripe, without the lens's distortion, (n,) [px].
        across: The other coordinate, (n,) [px].
        nearness: Weight of each, (n,): a stripe beside the board more likely lies on its plane than one far off.
        on_squares: Whether each shows a place among the board's squares, (n,).

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
    """Distance of each centre from the likeliest straight line, (n,), and the gate within which it is kept [px]."""
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
    """First and last line of pixels between which the stripe goes on from the board's squares without a step."""
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
    """Give each distance from the straight line, (n,), against the median of its neighbours': noise without bow."""
    return off - np.asarray(median_filter(off, 2 * NEIGHBOURS + 1, mode="nearest"), dtype=np.float64)


def _distance(along: Array, across: Array, slope: float, start: float) -> Array:
    return np.asarray((across - slope * along - start) / np.hypot(1.0, slope))


def _likeliest(along: Array, across: Array, weight: Array) -> tuple[float, float]:
    """Try lines through pairs of candidates and give slope and start of the one with the most weight near it."""
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
    """Keep of each line of pixels the candidate nearest to the straight line."""
    return best_of_each(line, np.where(able, -distance, -np.inf)) & able


def _undisturbed(centres: LineCentres, off: Array, kept: Bools) -> Bools:
    """Drop centres that jump out of their neighbours, or where the stripe's width changes along it."""
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
    """Whether around each candidate most lines of pixels that show light show it on the straight line."""
    height = int(line.max()) + 1
    lit, good = np.zeros(height), np.zeros(height)
    lit[line] = 1.0
    good[line[kept]] = 1.0
    window = np.ones(2 * NEIGHBOURS + 1)
    share = np.convolve(good, window, mode="same") / np.maximum(np.convolve(lit, window, mode="same"), 1.0)
    return np.asarray(share[line] >= LEAST_SUPPORT)
