"""What a sensor measures at poses that no fit has seen: planned ones, and those that cross-validation leaves out."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Points
from robolaser.parameters import Values

Seen = tuple[Points, Bools] | None
"""Rows of one pose after the other, as many of each, numbered from 0; and which poses see all of theirs, (p,)."""


@final
@dataclass(frozen=True, eq=False)
class NewPoses:
    """Plans of poses and cross-validation ask it.

    Attributes:
        seen_from: What would be measured at planned poses, from all parameters and T_base_flange (p, 4, 4); None where
            the flange cannot go elsewhere.
        aims: Likewise places on the flange, (a, 3), and where each must come for something to be seen; None where
            anywhere does.
        left_out_together: Group of each row, (m,), where cross-validation leaves out more than poses together; None:
            whole poses.
        located_apart: Errors of rows left out (m, k) once what only they can locate is located from them.
    """

    seen_from: Callable[[Values, Array], Seen]
    aims: Callable[[Values, Array], tuple[Array, Array] | None] = lambda values, T_base_flange: None
    left_out_together: Ints | None = None
    located_apart: Callable[[Array], Array] = lambda errors: errors


def each_once(points: Points, poses: int) -> Points:
    """Rows that have every named point once in each of some poses."""
    _, first = np.unique(points.number, return_index=True)
    rows = points.take(np.tile(np.sort(first), poses))
    return replace(rows, pose=np.repeat(np.arange(poses), len(first)), repeat=None)
