"""Several recordings of one scanner as one cloud."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Progress
from robolaser.scan.cloud import Cloud, Counts
from robolaser.scan.ply import Vertices


@final
@dataclass(frozen=True)
class MergedCloud:
    """The points of several recordings one after the other; their poses are numbered on."""

    clouds: tuple[Cloud, ...]

    @property
    def counts(self) -> Counts:
        """Of all."""
        each = [cloud.counts for cloud in self.clouds]
        return Counts(*(sum(getattr(one, name) for one in each) for name in ("centres", "points", "poses")))

    @property
    def what(self) -> str:
        """Where the stripes come from, for people."""
        return " and ".join(dict.fromkeys(cloud.what for cloud in self.clouds))

    @property
    def cameras(self) -> Array:
        """Positions of the camera by pose, (n, 3) [m]."""
        return np.concatenate([cloud.cameras for cloud in self.clouds])

    def pieces(self, progress: Progress | None = None) -> Iterator[Vertices]:
        """The points of one recording after the other, as `Cloud.pieces` gives them."""
        poses = 0
        for number, cloud in enumerate(self.clouds):

            def shared(what: str, done: float, number: int = number) -> None:
                if progress is not None:
                    progress(what, (number + done) / len(self.clouds))

            for piece in cloud.pieces(shared):
                piece["pose"] += poses
                yield piece
            poses += len(cloud.scanner.dataset.poses)
