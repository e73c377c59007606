"""Some rows of each group, evenly taken."""

import numpy as np

from robolaser.arrays import Ints


def some_of_each(group: Ints, most: int) -> Ints:
    """At most so many rows of each group (m,), evenly taken along them, (groups, most); -1 where it has fewer."""
    order = np.argsort(group, kind="stable")
    counts = np.bincount(group)
    starts = (np.cumsum(counts) - counts)[counts > 0, None]
    counts = counts[counts > 0, None]
    most = min(most, int(counts.max(initial=0)))
    taken, place = np.minimum(most, counts), np.arange(most)
    last = (place > 0) & (place == taken - 1)
    along = np.where(last, counts - 1, place * ((counts - 1) / np.maximum(taken - 1, 1)))
    rows = order[np.minimum(starts + along.round().astype(np.int64), len(order) - 1)]
    return np.where(place < taken, rows, -1)
