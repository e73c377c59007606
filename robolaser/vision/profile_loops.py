"""Profiles of a stripe measured above a level, a run of bright pixels at a time."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled.decorators import compiled
from robolaser.vision.profile_levels import FOOT, FULL, LEAST_TOLD, LEVEL


@compiled
def measured(across: Array, line: Ints, first: Ints, last: Ints, ground: Array, reach: int, told: Array) -> None:
    """Measure each run's profile above two levels.

    Args:
        across: The image, (lines, length) [grey, 0 to 255].
        line: Line of each run, (n,).
        first: Its first pixel, (n,).
        last: Its last pixel, (n,).
        ground: Grey beside it, (n,).
        reach: Pixels on either side of its middle that flanks are looked for in.
        told: Takes middle, width, area and the squared distances that the middle hangs on, above LEVEL and above FOOT,
            NaN where a flank is missing; then the peak and the number of saturated pixels, (n, 10).
    """
    length = across.shape[1]
    for i in range(len(line)):
        row = across[line[i]]
        peak, head, tail, full = 0, first[i], first[i], 0
        for column in range(first[i], last[i] + 1):
            grey = row[column]
            if grey > peak:
                peak, head = grey, column
            if grey == peak:
                tail = column
            if grey == FULL:
                full += 1
        seat, centre = (head + tail) // 2, (first[i] + last[i]) // 2
        low, high = max(0, centre - reach), min(length - 1, centre + reach)
        above = ground[i] + LEVEL * (peak - ground[i])
        told[i, 0], told[i, 1], told[i, 2], told[i, 3] = _mass_above(above, row, seat, low, high)
        above = ground[i] + FOOT * (peak - ground[i])
        told[i, 4], told[i, 5], told[i, 6], told[i, 7] = _mass_above(above, row, seat, low, high)
        told[i, 8], told[i, 9] = peak, full


@compiled
def _mass_above(level: float, row: Array, seat: int, low: int, high: int) -> tuple[float, float, float, float]:
    """Centre of mass, width, area and squared distances between the flanks; NaN where one is missing."""
    before, after = seat - 1, seat + 1
    while before >= low and row[before] > level:
        before -= 1
    while after <= high and row[after] > level:
        after += 1
    if before < low or after > high or not row[seat] > level:
        return np.nan, np.nan, np.nan, np.nan
    area = moment = 0.0
    for column in range(before + 1, after):
        a = row[column] - level
        area += a
        moment += a * (column - seat)
    head, tail = before + 1 - seat, after - 1 - seat
    a_head, a_tail = row[before + 1] - level, row[after - 1] - level
    to_head = a_head / (a_head + level - row[before])
    to_tail = a_tail / (a_tail + level - row[after])
    area -= 0.5 * (a_head * (1 - to_head) + a_tail * (1 - to_tail))
    moment += (a_tail - a_head) / 12 - a_head * (head / 2 - 1 / 4) - a_tail * (tail / 2 + 1 / 4)
    moment += 0.5 * (a_head * to_head * (head - to_head / 3) + a_tail * to_tail * (tail + to_tail / 3))
    middle = moment / area
    told = 0.0
    for column in range(before + 1, after):
        if row[column] < FULL:
            told += (column - seat - middle) ** 2
    if row[before + 1] < FULL:
        told -= (0.75 - 0.25 * to_head * (2 + to_head)) * (head - middle) ** 2
    if row[after - 1] < FULL:
        told -= (0.75 - 0.25 * to_tail * (2 + to_tail)) * (tail - middle) ** 2
    return seat + middle, tail - head + to_head + to_tail, area, max(told, LEAST_TOLD)


def warm_up() -> None:
    """Compile `measured`."""
    numbers = np.zeros(1, np.int64)
    measured(np.zeros((1, 8), np.uint8), numbers, numbers, numbers, np.zeros(1), 2, np.zeros((1, 10)))
