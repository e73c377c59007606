"""Distances between named points that are known beforehand: rows of one number in metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Noise
from robolaser.parameters import Values

USUAL_M = 5e-5  # standard deviation where `[noise] distance_m` does not state one: a plate from a milling machine


@final
@dataclass(frozen=True, eq=False)
class KnownDistances:
    """Rows of a data set that belong to no pose and to no point of points.csv."""

    # parameters of each row's first point, such as `socket.a.x`, `.y` and `.z`, (r,)
    first: tuple[tuple[str, ...], ...]
    second: tuple[tuple[str, ...], ...]  # those of its second, (r,)
    known: Array  # the distances, (r,) [m]
    sigma_m: float  # their standard deviation

    @classmethod
    def of(cls, pairs: Sequence[tuple[tuple[str, ...], tuple[str, ...], float]], noise: Noise) -> "KnownDistances":
        """From the parameters of pairs of points with their distance [m]."""
        first, second, known = zip(*pairs, strict=True)
        return cls(first, second, np.array(known), USUAL_M if noise.distance_m is None else noise.distance_m)

    def __len__(self) -> int:
        return len(self.known)

    def residuals(self, values: Values) -> Array:
        """Known distance less the model's, (c, r) [m]."""
        left: Array = self.known - np.linalg.norm(self._apart(values), axis=-1)
        return left

    def jacobian(self, values: Values, names: Sequence[str]) -> Array:
        """Derivatives of the residuals by the named parameters, (c, r, len(names)); zero by all that are no points."""
        apart = self._apart(values)
        with np.errstate(invalid="ignore"):
            along = np.nan_to_num(apart / np.linalg.norm(apart, axis=-1, keepdims=True))
        column = {name: i for i, name in enumerate(names)}
        slopes = np.zeros((*along.shape[:2], len(names)))
        for row, (first, second) in enumerate(zip(self.first, self.second, strict=True)):
            for axis in range(3):
                for point, sign in ((first, 1.0), (second, -1.0)):
                    if (at := column.get(point[axis])) is not None:
                        slopes[:, row, at] += sign * along[:, row, axis]
        return slopes

    def _apart(self, values: Values) -> Array:
        """From each row's first point to its second, (c, r, 3) [m]."""
        parts = [
            np.stack([values[b] - values[a] for a, b in zip(first, second, strict=True)], axis=-1)
            for first, second in zip(self.first, self.second, strict=True)
        ]
        return np.stack(parts, axis=1)
