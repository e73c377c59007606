"""What passes on its way into a file, remembered in part: enough of a cloud to look at and to measure on."""

from collections.abc import Iterable, Iterator
from typing import final

import numpy as np

from robolaser.scan.ply import VERTEX, Vertices

MOST = 200_000  # points: more say no more about a plane, and show no more in a picture


@final
class Subsample:
    """Evenly taken points of a cloud of unknown size: every one at first, then ever fewer.

    Args:
        most: Points remembered, at most.
    """

    def __init__(self, most: int = MOST) -> None:
        self._most, self._every, self._ahead = most, 1, 0
        self._kept: list[Vertices] = []
        self._count = 0

    def watch(self, pieces: Iterable[Vertices]) -> Iterator[Vertices]:
        """Hand on pieces, (n,) of VERTEX each, and remember some of their points."""
        for piece in pieces:
            taken = piece[self._ahead :: self._every].copy()
            self._ahead = (self._ahead - len(piece)) % self._every
            self._kept.append(taken)
            self._count += len(taken)
            while self._count > self._most:
                self._thin()
            yield piece

    @property
    def vertices(self) -> Vertices:
        """What was remembered, in the order in which it came, (m,) of VERTEX."""
        return np.concatenate([np.empty(0, VERTEX), *self._kept])

    def _thin(self) -> None:
        """Forget every other point."""
        whole = self.vertices
        self._ahead += self._every * (len(whole) % 2)
        self._kept = [whole[::2].copy()]
        self._count = len(self._kept[0])
        self._every *= 2
