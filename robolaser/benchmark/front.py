"""A front: what no other candidate dominates, where there are several objectives.

The cost of a run is the hypervolume that its front misses, so all that is said of runs with one objective holds:
targets, running times, ranks.
"""

from dataclasses import dataclass, replace
from typing import final

import moocore
import numpy as np

from robolaser.arrays import Array

REFERENCE = 1.1
"""Where hypervolume is measured from, in each objective: 0 is the ideal point, 1 the nadir point."""


@final
@dataclass(frozen=True, eq=False)
class Front:
    """Objective values that no other dominates."""

    ideal: Array  # the lowest value of each objective on the best known front, (m,)
    nadir: Array  # the highest there, (m,)
    attainable: float  # hypervolume of the best known front
    points: Array  # the values, (n, m)
    x: Array  # whose values they are, (n, d)

    @classmethod
    def empty(cls, variables: int, ideal: Array, nadir: Array, known: Array | None = None) -> "Front":
        """Of no points yet, for a problem whose front is `known`, (k, m), or not: then all of the box is attainable."""
        nadir, none = np.where(nadir > ideal, nadir, ideal + 1.0), np.empty((0, len(ideal)))
        box = cls(ideal, nadir, REFERENCE ** len(ideal), none, np.empty((0, variables)))
        return box if known is None else replace(box, attainable=replace(box, points=known).hypervolume)

    @property
    def hypervolume(self) -> float:
        """Hypervolume that it dominates, in units of the box from the ideal to the nadir point."""
        scaled = (self.points - self.ideal) / (self.nadir - self.ideal)
        return float(moocore.hypervolume(scaled, ref=np.full(len(self.ideal), REFERENCE))) if len(scaled) else 0.0

    @property
    def missing(self) -> float:
        """Hypervolume that it lacks of what is attainable."""
        return self.attainable - self.hypervolume

    def extended(self, values: Array, x: Array) -> "Front":
        """With further values (c, m) of candidates (c, d), as far as nothing dominates them."""
        if not len(values):
            return self
        both = np.concatenate([self.points, values])
        kept = moocore.is_nondominated(both)
        return replace(self, points=both[kept], x=np.concatenate([self.x, x])[kept])
