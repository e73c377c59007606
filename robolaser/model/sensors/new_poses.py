"""What a sensor measures at poses that no fit has seen: planned ones, and those that cross-validation leaves out."""

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.parameters import Values


class NewPoses(ABC):
    """Plans of poses and cross-validation ask it."""

    @abstractmethod
    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools] | None:
        """What would be measured at planned poses.

        Args:
            values: All parameters.
            T_base_flange: (p, 4, 4).

        Returns:
            Rows of one pose after the other, as many of each, numbered from 0; and which poses see all of theirs, (p,).
            None where the flange cannot go elsewhere.
        """

    def aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array] | None:
        """Places on the flange, (a, 3), and where each must come for something to be seen; None where anywhere does."""
        return None

    @property
    def left_out_together(self) -> Ints | None:
        """Group of each row, (m,), where cross-validation leaves out more than poses together; None: whole poses."""
        return None

    def located_apart(self, errors: Array) -> Array:
        """Errors of rows left out (m, k) once what only they can locate is located from them."""
        return errors


@final
class NamedPoints(NewPoses):
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
