"""Some of many rows, evenly taken: of all, of each group, or of some groups whole."""

import numpy as np

from robolaser.arrays import Bools, Ints


def evenly(count: int, most: int) -> Ints:
    """Places of at most so many out of `count` things, the first and the last among them, (k,)."""
    return np.asarray(np.linspace(0, max(count - 1, 0), min(count, most)).round().astype(np.int64))


def of_some_groups(group: Ints, most: int) -> Bools:
    """Mark the rows of at most so many groups (m,), evenly taken along their numbers, (m,)."""
    seen, number = np.unique(group, return_inverse=True)
    chosen = np.zeros(len(seen), dtype=bool)
    chosen[evenly(len(seen), most)] = True
    return np.asarray(chosen[number])


def rows_of_each(group: Ints, most: int) -> Ints:
    """The rows that `some_of_each` takes, in their order, (k,)."""
    table = some_of_each(group, most)
    return np.sort(table[table >= 0])


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
