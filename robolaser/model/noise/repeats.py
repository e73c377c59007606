"""What shots at an unmoved pose say of the noise of pixels."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.model.grouped_rows import group_sums

LEAST_REPEATS = 10  # differences between repeats, below which the residuals know more
GROSS = 5.0  # standard deviations beyond which a repeat is a gross error, not noise
NORMAL_MEDIAN = 0.6745  # median of |N(0, 1)|


@final
@dataclass(frozen=True)
class PixelRepeats:
    """Scatter of pixels between shots."""

    sigma_px: float  # pooled standard deviation
    freedoms: int  # independent differences that it rests on


def pixel_from_repeats(dataset: Dataset) -> float | None:
    """Pooled standard deviation of pixels between shots at an unmoved pose [px]; None where repeats are too few."""
    repeats = pixel_repeats(dataset)
    return None if repeats is None else repeats.sigma_px


def pixel_repeats(dataset: Dataset) -> PixelRepeats | None:
    """All that repeats say of the pixels; None where they are too few.

    Repeats with a gross error, judged by the median deviation, are left out.
    """
    if dataset.points.pixel is None or dataset.points.repeat is None:
        return None
    group = dataset.points.place
    count = np.bincount(group)
    deviation = dataset.points.pixel - (group_sums(dataset.points.pixel, group) / count[:, None])[group]
    free = (count - 1)[group] / count[group]  # share of the variance that a deviation from the group's mean keeps
    repeated = free > 0
    if (count - 1).sum() < LEAST_REPEATS:
        return None
    normal = np.abs(deviation[repeated]) / np.sqrt(free[repeated, None])
    largest = GROSS * float(np.median(normal)) / NORMAL_MEDIAN
    gross = np.zeros(len(count), dtype=bool)
    gross[group[repeated][(normal > largest).any(axis=1)]] = True
    kept = ~gross
    degrees = 2 * int((count - 1)[kept].sum())
    sigma = float(np.sqrt((deviation[kept[group]] ** 2).sum() / degrees))
    return PixelRepeats(sigma, degrees)
