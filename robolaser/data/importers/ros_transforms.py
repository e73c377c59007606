"""The tree of frames that ROS calls tf, over time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.importers.time_matching import match
from robolaser.errors import DataError, near
from robolaser.geometry.rigid_motion import inverse


@final
@dataclass(frozen=True)
class Transforms:
    """All frames of a recording."""

    file: str  # where they are from
    parents: Mapping[str, str]  # of each frame
    # T_parent_frame of each frame, (n, 4, 4), and its times, sorted, (n,) [s]; one motion without a time: it is static
    motions: Mapping[str, tuple[Array, Array]]

    def lookup(self, target: str, source: str, at_s: Array, tolerance_s: float) -> tuple[Array, Bools, Array]:
        """T_target_source at times (m,): (m, 4, 4), whether all that moves was known then, (m,), and how far off, (m,).

        Raises:
            DataError: There is no such frame, or the two are in separate trees.
        """
        known, away = np.ones(len(at_s), dtype=bool), np.zeros(len(at_s))
        motions = []
        for chain in self._chains(target, source):
            T = np.broadcast_to(np.eye(4), (len(at_s), 4, 4))
            for frame in chain:
                moved, time_s = self.motions[frame]
                if len(time_s):
                    found = match(time_s, at_s, tolerance_s)
                    known &= found.near
                    away = np.maximum(away, found.away_s)
                    moved = found.motions(moved)
                T = moved @ T
            motions.append(T)
        return inverse(motions[0]) @ motions[1], known, away

    def times(self, target: str, source: str) -> Array:
        """Times at which the source was seen from the target: those of the moving frame nearest to the source.

        Raises:
            DataError: There is no such frame, the two are in separate trees, or nothing moves between them.
        """
        up, down = self._chains(target, source)
        for frame in (*down, *reversed(up)):
            _, time_s = self.motions[frame]
            if len(time_s):
                return time_s
        raise DataError(f"{self.file}: nothing moves between the frames {target} and {source}.", file=self.file)

    def _chains(self, target: str, source: str) -> tuple[list[str], list[str]]:
        """Frames from each of the two up to below the first that they share."""
        up, down = self._above(target), self._above(source)
        shared = [frame for frame in up if frame in down]
        if not shared:
            raise DataError(f"{self.file}: the frames {target} and {source} are in separate trees.", file=self.file)
        return up[: up.index(shared[0])], down[: down.index(shared[0])]

    def _above(self, frame: str) -> list[str]:
        """The frame and all above it, up to the root."""
        known = {*self.parents, *self.parents.values()}
        if frame not in known:
            raise DataError(f"{self.file} has no frame {frame} in tf.{near(frame, sorted(known), 12)}", file=self.file)
        found = [frame]
        while found[-1] in self.parents:
            found.append(self.parents[found[-1]])
            if len(found) > len(self.parents) + 1:
                raise DataError(f"{self.file}: the frames above {frame} form a loop.", file=self.file)
        return found
