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
    """Objective values that no other dominates.

    Attributes:
        ideal: The lowest value of each objective on the best known front, (m,).
        nadir: The highest there, (m,).
        attainable: Hypervolume of the best known front.
        points: The values, (n, m).
    """

    ideal: Array
    nadir: Array
    attainable: float
    points: Array

    @classmethod
    def empty(cls, ideal: Array, nadir: Array, known: Array | None = None) -> "Front":
        """Of no points yet, for a problem whose front is `known`, (k, m), or not: then all of the box is attainable."""
        box = cls(
            ideal, np.where(nadir > ideal, nadir, ideal + 1.0), REFERENCE ** len(ideal), np.empty((0, len(ideal)))
        )
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

    def extended(self, values: Array) -> "Front":
        """With further values (c, m), as far as nothing dominates them."""
        if not len(values):
            return self
        both = np.concatenate([self.points, values])
        return replace(self, points=both[moocore.is_nondominated(both)])
