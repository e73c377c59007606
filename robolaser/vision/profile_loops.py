"""Profiles of a stripe measured above a level, a run of bright pixels at a time."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled.decorators import compiled
from robolaser.vision.profile_levels import FOOT, FULL, LEAST_SECOND_MOMENT, LEVEL


@compiled
def measured(across: Array, line: Ints, first: Ints, last: Ints, ground: Array, reach: int, moments: Array) -> None:
    """Measure each run's profile above two levels.

    Args:
        across: The image, (lines, length) [grey, 0 to 255].
        line: Line of each run, (n,).
        first: Its first pixel, (n,).
        last: Its last pixel, (n,).
        ground: Grey beside it, (n,).
        reach: Pixels on either side of its centre that flanks are looked for in.
        moments: Takes centre, width, area and the sum of squared distances, above LEVEL and above FOOT,
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
        peak_column, mid_column = (head + tail) // 2, (first[i] + last[i]) // 2
        low, high = max(0, mid_column - reach), min(length - 1, mid_column + reach)
        above = ground[i] + LEVEL * (peak - ground[i])
        moments[i, 0], moments[i, 1], moments[i, 2], moments[i, 3] = _above_level(above, row, peak_column, low, high)
        above = ground[i] + FOOT * (peak - ground[i])
        moments[i, 4], moments[i, 5], moments[i, 6], moments[i, 7] = _above_level(above, row, peak_column, low, high)
        moments[i, 8], moments[i, 9] = peak, full


@compiled
def _above_level(level: float, row: Array, peak_column: int, low: int, high: int) -> tuple[float, float, float, float]:
    """Centre of gravity, width, area and squared distances between the flanks; NaN where one is missing."""
    before, after = peak_column - 1, peak_column + 1
    while before >= low and row[before] > level:
        before -= 1
    while after <= high and row[after] > level:
        after += 1
    if before < low or after > high or not row[peak_column] > level:
        return np.nan, np.nan, np.nan, np.nan
    area = moment = 0.0
    for column in range(before + 1, after):
        a = row[column] - level
        area += a
        moment += a * (column - peak_column)
    head, tail = before + 1 - peak_column, after - 1 - peak_column
    a_head, a_tail = row[before + 1] - level, row[after - 1] - level
    to_head = a_head / (a_head + level - row[before])
    to_tail = a_tail / (a_tail + level - row[after])
    area -= 0.5 * (a_head * (1 - to_head) + a_tail * (1 - to_tail))
    moment += (a_tail - a_head) / 12 - a_head * (head / 2 - 1 / 4) - a_tail * (tail / 2 + 1 / 4)
    moment += 0.5 * (a_head * to_head * (head - to_head / 3) + a_tail * to_tail * (tail + to_tail / 3))
    centre = moment / area
    moments = 0.0
    for column in range(before + 1, after):
        if row[column] < FULL:
            moments += (column - peak_column - centre) ** 2
    if row[before + 1] < FULL:
        moments -= (0.75 - 0.25 * to_head * (2 + to_head)) * (head - centre) ** 2
    if row[after - 1] < FULL:
        moments -= (0.75 - 0.25 * to_tail * (2 + to_tail)) * (tail - centre) ** 2
    return peak_column + centre, tail - head + to_head + to_tail, area, max(moments, LEAST_SECOND_MOMENT)


def warm_up() -> None:
    """Compile `measured`."""
    numbers = np.zeros(1, np.int64)
    measured(np.zeros((1, 8), np.uint8), numbers, numbers, numbers, np.zeros(1), 2, np.zeros((1, 10)))
