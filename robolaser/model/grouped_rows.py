"""Rows that belong together, side by side: sums and products over each group become one batch of small products."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
@dataclass(frozen=True, eq=False)
class GroupedRows:
    """Rows by the number of their group, which need not be in order, nor of one size."""

    group: Ints  # of each row, (m,)

    @cached_property
    def _order(self) -> Ints | None:
        """Rows in the order of their groups; None where they are in order, each group of the same size."""
        counts = np.bincount(self.group)
        if (np.diff(self.group) >= 0).all() and (counts == counts[0]).all():
            return None
        return np.argsort(self.group, kind="stable").astype(np.int64)

    @cached_property
    def _place(self) -> tuple[Ints, Ints]:
        """Group and place within it of each row in that order, (m,) each."""
        order = np.arange(len(self.group)) if self._order is None else self._order
        group = self.group[order]
        first = np.concatenate([[0], np.cumsum(np.bincount(self.group))[:-1]])
        return group, np.arange(len(group)) - first[group]

    @property
    def count(self) -> int:
        """Numbers of groups up to the largest."""
        return int(self.group.max()) + 1

    def apart(self, rows: Array) -> Array:
        """Rows (m, ...) by group, zero where a group has fewer, (g, r, ...)."""
        if self._order is None:
            return rows.reshape(self.count, len(rows) // self.count, *rows.shape[1:])
        group, place = self._place
        grouped = np.zeros((self.count, int(place.max()) + 1, *rows.shape[1:]))
        grouped[group, place] = rows[self._order]
        return grouped

    def together(self, grouped: Array) -> Array:
        """The rows (m, ...) of what `apart` returns."""
        if self._order is None:
            return grouped.reshape(len(self.group), *grouped.shape[2:])
        rows = np.empty((len(self.group), *grouped.shape[2:]))
        rows[self._order] = grouped[self._place]
        return rows


def group_sums(rows: Array, group: Ints) -> Array:
    """Sum rows (m, ...) that share a group's number (m,), -> (largest number + 1, ...)."""
    apart = np.diff(group)
    if (apart < 0).any():
        order = np.argsort(group, kind="stable")
        rows, group = rows[order], group[order]
    elif len(group) == group[-1] + 1 and (apart > 0).all():
        return rows
    numbers, starts = np.unique(group, return_index=True)
    sums = np.zeros((int(group[-1]) + 1, *rows.shape[1:]))
    sums[numbers] = np.add.reduceat(rows, starts, axis=0)
    return sums
