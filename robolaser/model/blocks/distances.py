"""Known distances between named points: additional rows in every fit, one number in metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast, final

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import Dual, is_dual
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.parameters import Values

USUAL_M = 5e-5  # standard deviation where `[noise] distance_m` does not state one: a plate from a milling machine


@final
@dataclass(frozen=True, eq=False)
class KnownDistances:
    """Rows of a data set that belong to no pose and to no point of points.csv."""

    # parameters of each row's first point, such as `socket.a.x`, `.y` and `.z`, (r,)
    first: tuple[tuple[str, ...], ...]
    second: tuple[tuple[str, ...], ...]  # of its second, (r,)
    known: Array  # the distances, (r,) [m]
    sigma_m: float  # their standard deviation

    def __len__(self) -> int:
        return len(self.known)

    def residuals(self, values: Values) -> Array:
        """Known distance less the model's, (c, r) [m]."""
        left: Array = self.known - np.linalg.norm(self._apart(values), axis=-1)
        return left

    def jacobian(self, values: Values, names: Sequence[str]) -> Array:
        """Derivatives of the residuals by the named parameters, (c, r, len(names)); zero except by points."""
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


def known_distances(blocks: Blocks) -> KnownDistances | None:
    """The stated distances between named points, each once; None where there are none."""
    rows, noise = {}, blocks.dataset.noise
    for block in blocks:
        for one, other, distance in block.sensor.dataset.distances_m:
            first, second = _place(block, one), _place(block, other)
            if first and second:
                rows[first, second], noise = distance, block.sensor.dataset.noise
    if not rows:
        return None
    firsts, seconds = zip(*rows, strict=True)
    sigma_m = USUAL_M if noise.distance_m is None else noise.distance_m
    return KnownDistances(firsts, seconds, np.array(list(rows.values())), sigma_m)


def _place(block: Block, point: str) -> tuple[str, ...]:
    """The problem's names of a named point's coordinates; none where it has no such point."""
    own = (f"{block.sensor.format.named_points}.{point}.{part}" for part in "xyz")
    return tuple(block.named[name] for name in own if name in block.named)
