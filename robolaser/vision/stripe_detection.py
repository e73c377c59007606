"""A laser stripe in an image: where its centre lies, in every line of pixels that crosses it."""

from dataclasses import dataclass, fields
from typing import Literal, final

import cv2
import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.vision.board import Image
from robolaser.vision.gaussian_fit import gaussian_fit
from robolaser.vision.runs import find_runs, measure

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


def find_line_centres(image: Image, axis: Axis) -> LineCentres:
    """Find every bright run that may be the stripe and the middle of each, to a fraction of a pixel.

    Runs cut by the image's border have no centre and are left out.

    Args:
        image: Grey image, (height, width).
        axis: Image axis that the stripe runs along: one centre per row for "v", per column for "u".

    Returns:
        The candidates, by line and then by place in the line.
    """
    across = image if axis == "v" else np.asarray(cv2.transpose(image), dtype=image.dtype)
    runs = find_runs(across)
    profiles = measure(runs)
    centre, std = gaussian_fit(runs, profiles)
    found = LineCentres(
        line=runs.line,
        pixel=np.stack([centre, runs.line] if axis == "v" else [runs.line, centre], axis=-1),
        std=std,
        width=profiles.width,
        light=profiles.light,
        peak=profiles.peak,
        ground=profiles.ground,
        asymmetry=profiles.asymmetry,
    )
    return found.at(np.isfinite(centre) & np.isfinite(profiles.centre) & np.isfinite(std))
