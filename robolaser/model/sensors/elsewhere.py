"""What a sensor would measure at other poses than those of its data set."""

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset, Points
from robolaser.parameters import Values


class Elsewhere(ABC):
    """Plans of poses ask it."""

    @abstractmethod
    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """What would be measured.

        Args:
            values: All parameters.
            T_base_flange: (p, 4, 4).

        Returns:
            Rows of one pose after the other, as many of each, numbered from 0; and which poses see all of theirs, (p,).
        """

    def aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array] | None:
        """Places on the flange, (a, 3), and where each must come for something to be seen; None where anywhere does."""
        return None


@final
class NamedPoints(Elsewhere):
    """Each named point once, from everywhere."""

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset

    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """The rows that first name a point."""
        poses = len(T_base_flange)
        return each_once(self._dataset.points, poses), np.ones(poses, dtype=bool)


def each_once(points: Points, poses: int) -> Points:
    """Rows that have every named point once in each of some poses."""
    _, first = np.unique(points.number, return_index=True)
    rows = points.take(np.tile(np.sort(first), poses))
    return replace(rows, pose=np.repeat(np.arange(poses), len(first)), repeat=None)
