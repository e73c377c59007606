"""The noise of pixels, estimated from repeated shots at an unmoved pose."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.model.grouped_rows import group_sums

LEAST_REPEATS = 10  # differences between repeats, below which the residuals are more informative
GROSS = 5.0  # standard deviations beyond which a repeat is a gross error, not noise
NORMAL_MEDIAN = 0.6745  # median of |N(0, 1)|


@final
@dataclass(frozen=True)
class PixelRepeats:
    """Scatter of pixels between shots."""

    sigma_px: float  # pooled standard deviation
    freedoms: int  # independent differences behind it
    shared_px: Array  # standard deviation shared by all rows of an image, along u and v, (2,)
    shared_z: Array  # standard deviations by which the logarithm of its variance ratio exceeds that of chance, (2,)


def pixel_repeats(dataset: Dataset) -> PixelRepeats | None:
    """Scatter of pixels between shots at an unmoved pose; None where repeats are too few.

    Repeats with a gross error, judged by the median deviation, are excluded.
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
    largest = GROSS * float(np.median(normal).round(9)) / NORMAL_MEDIAN or np.inf  # most may be alike: whole pixels
    gross = np.zeros(len(count), dtype=bool)
    gross[group[repeated][(normal > largest).any(axis=1)]] = True
    kept = ~gross
    if not (degrees := 2 * int((count - 1)[kept].sum())):
        return None
    sigma = float(np.sqrt((deviation[kept[group]] ** 2).sum() / degrees))
    return PixelRepeats(sigma, degrees, *_shared(dataset, deviation, kept[group] & repeated))


def _shared(dataset: Dataset, deviation: Array, rows: Bools) -> tuple[Array, Array]:
    """The deviation shared by rows of an image, by an analysis of variance, and how far it is from chance.

    Means of images scatter by the noise of a row over their number, unless something moves all rows of an image.
    """
    points = dataset.points
    assert points.repeat is not None  # groups of these deviations
    image = np.unique(np.column_stack([points.pose, points.repeat])[rows], axis=0, return_inverse=True)[1].reshape(-1)
    poses, own = len(np.unique(points.pose[rows])), deviation[rows]
    count = np.bincount(image)[:, None]
    means = group_sums(own, image) / count
    between, within = len(count) - poses, len(own) - len(np.unique(points.place[rows])) - (len(count) - poses)
    if min(between, within) < LEAST_REPEATS:
        return np.zeros(2), np.zeros(2)
    inner = ((own - means[image]) ** 2).sum(axis=0) / within
    ratio = (count * means**2).sum(axis=0) / between / np.maximum(inner, np.finfo(float).tiny)
    shared = np.sqrt(np.maximum(ratio - 1.0, 0.0) * inner / count.mean())
    return shared, np.log(np.maximum(ratio, np.finfo(float).tiny)) / np.sqrt(2.0 / between + 2.0 / within)
