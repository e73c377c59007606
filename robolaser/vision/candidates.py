"""Centres of a stripe in an image, and what is known of each."""

from dataclasses import dataclass, fields
from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints

Axis = Literal["u", "v"]
MOST_ASYMMETRY = 0.15
"""Shift of the centre between foot and top, as a share of the width, beyond which a profile is no stripe's."""


@final
@dataclass(frozen=True)
class LineCentres:
    """Centres of bright runs, several to a line of pixels where light is double."""

    line: Ints  # row (column, where the stripe runs along u) of each centre, (n,)
    pixel: Array  # the centre, (n, 2) [px] as (u, v)
    std: Array  # standard deviation of the centre along its line of pixels, by the image's noise, (n,) [px]
    width: Array  # between the flanks, (n,) [px]
    light: Array  # grey above the background, summed over the run, (n,)
    peak: Array  # brightest grey of the run, (n,)
    ground: Array  # grey beside the run, (n,)
    asymmetry: Array  # middle near the foot against centre near the top, (n,) [px]

    def __len__(self) -> int:
        return len(self.line)

    @property
    def is_symmetric(self) -> Bools:
        """Whether each profile is as even as a stripe's, (n,)."""
        return np.asarray(np.abs(self.asymmetry) <= MOST_ASYMMETRY * self.width)

    def at(self, kept: Bools | Ints) -> "LineCentres":
        """Give some of them, by mask or index."""
        return LineCentres(**{item.name: getattr(self, item.name)[kept] for item in fields(self)})


def every(line: Ints, step: int) -> Ints:
    """Of lines of pixels (n,) those that lie `step` apart in the image, (k,); the one in the centre where none does."""
    chosen = np.flatnonzero(line % step == step // 2)
    return chosen if len(chosen) else np.arange(len(line))[len(line) // 2 :][:1]
