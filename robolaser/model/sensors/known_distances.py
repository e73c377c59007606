"""Distances between named points that are known beforehand: rows of one number in metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Noise
from robolaser.duals import Dual, is_dual
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
        moving = {name: Dual.parameter(values[name], i) for i, name in enumerate(names) if name in values}
        left: Any = self.residuals(cast("Values", {**values, **moving}))
        slopes = np.zeros((*left.shape, len(names)))
        if is_dual(left):
            slopes[..., list(left.of)] = np.moveaxis(left.slopes, 0, -1)
        return slopes

    def _apart(self, values: Values) -> Array:
        """From each row's first point to its second, (c, r, 3) [m]."""
        parts = [
            np.stack([values[b] - values[a] for a, b in zip(first, second, strict=True)], axis=-1)
            for first, second in zip(self.first, self.second, strict=True)
        ]
        return np.stack(parts, axis=1)
