"""Rows in groups: sums and products over each group become one batch of small products."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
@dataclass(frozen=True, eq=False)
class GroupedRows:
    """Rows by the number of their group; groups may be in any order, of any size."""

    group: Ints  # of each row, (m,)

    @cached_property
    def _slots(self) -> tuple[Ints, Ints]:
        """The row in each slot of a group, (g, r), m where there is none; and the slot of each row, (m,)."""
        order, counts = np.argsort(self.group, kind="stable"), np.bincount(self.group)
        group = self.group[order]
        slot = group * counts.max() + np.arange(len(group)) - (np.cumsum(counts) - counts)[group]
        rows, slots = np.full((len(counts), counts.max()), len(group)), np.empty_like(slot)
        rows.flat[slot], slots[order] = order, slot
        return rows, slots

    def apart(self, rows: Array) -> Array:
        """Rows (m, ...) by group, zero where a group has fewer, (g, r, ...)."""
        at, _ = self._slots
        grouped = rows.take(at, axis=0, mode="clip")
        if at.max() == len(rows):
            grouped[at == len(rows)] = 0.0
        return grouped

    def together(self, grouped: Array) -> Array:
        """The rows (m, ...) from the result of `apart`."""
        at, slots = self._slots
        return grouped.reshape(at.size, *grouped.shape[2:]).take(slots, axis=0)


def group_means(rows: Array, group: Ints, groups: int = 0) -> Array:
    """The mean of rows (m, k) that share a group's number (m,), for so many groups or more, (g, k); 0 of no row."""
    sums = np.stack([np.bincount(group, column, minlength=groups) for column in rows.T], axis=-1)
    return np.asarray(sums / np.bincount(group, minlength=groups).clip(min=1)[:, None])


def group_sums(rows: Array, group: Ints) -> Array:
    """Sum rows (m, ...) that share a group's number (m,), -> (largest number + 1, ...)."""
    order = np.argsort(group, kind="stable")
    rows, group = rows[order], group[order]
    numbers, starts = np.unique(group, return_index=True)
    sums = np.zeros((int(group[-1]) + 1, *rows.shape[1:]))
    sums[numbers] = np.add.reduceat(rows, starts, axis=0)
    return sums
