"""Images or poses that were exchanged: rows far off where they are, which fit at each other's poses."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.misread import FALLS
from robolaser.calibration.result import rms, rms_of_poses
from robolaser.data.dataset import Dataset
from robolaser.model.batches import of_data
from robolaser.model.forward_model import Model

FAR: Final = 2.0
"""Times the median pose's error from which on a pose is far off, and by which its rows fit better elsewhere."""
MOST_FAR: Final = 20  # of them, the worst: each is tried at each other's place
FITS: Final = 3.0
"""Times the error of all other poses, up to which rows fit. A judgement: exchanged ones are hundreds of it off."""


def seem_exchanged(model: Model, x: Array, errors_m: Array) -> Mapping[int, int]:
    """The pose where the rows of another one fit far better, for poses that are exchanged among each other.

    By the model of all rows at x (d,), and the errors that it leaves, (m, j) [m].
    """
    of_pose = rms_of_poses(errors_m, model.dataset.points.pose, len(model.dataset.poses))
    far = np.flatnonzero(of_pose > FAR * np.nanmedian(of_pose))
    far = np.sort(far[np.argsort(-of_pose[far])][:MOST_FAR])
    if len(far) < 2:
        return {}
    errors = _errors_at_each_other(model, x, far)
    fits = FAR * errors.min(axis=1) < errors.diagonal()
    if not fits.any():
        return {}
    among = errors[np.ix_(fits, fits)]  # rows fit as well at a copy of their pose, which has its own
    belongs = dict(zip(far[fits].tolist(), far[fits][among.argmin(axis=1)].tolist(), strict=True))
    while set(belongs) != set(belongs.values()):
        belongs = {a: b for a, b in belongs.items() if a in belongs.values() and b in belongs}
    return belongs


def with_rows_at(dataset: Dataset, belongs: Mapping[int, int]) -> Dataset:
    """The data set with all rows of some poses at others."""
    to = np.arange(len(dataset.poses))
    to[list(belongs)] = list(belongs.values())
    return replace(dataset, points=replace(dataset.points, pose=to[dataset.points.pose]))


def belong_there(belongs: Mapping[int, int], model: Model, as_read_m: Array, moved_m: Array) -> bool:
    """Whether exchanged rows fit as well as all others, once the model is fitted to them where they belong.

    Where all others are centimetres off, something else is wrong.

    Args:
        belongs: The poses.
        model: Of the rows as they are read.
        as_read_m: What its fit leaves, (m, j) [m].
        moved_m: What is left of each row by a fit with rows moved, (m, j) [m].
    """
    moved = np.isin(model.dataset.points.pose, list(belongs))
    others = rms(moved_m[~moved])
    return others < SETUP_RMS_M and rms(moved_m[moved]) < min(FITS * others, rms(as_read_m[moved]) / FALLS)


def _errors_at_each_other(model: Model, x: Array, far: Ints) -> Array:
    """Root-mean-square error of all rows of each pose at each of them, (f, f) [m]."""
    points, f = model.dataset.points, len(far)
    own, rows = np.nonzero(points.pose == far[:, None])
    moved = replace(points.take(np.tile(rows, f)), pose=np.repeat(far, len(rows)))
    there = of_data(model, replace(model.dataset, points=moved))
    squares = np.square(there.in_metres(x, there.residuals(x[None])[0])).sum(axis=-1).reshape(f, -1)
    sums = np.array([np.bincount(own, some) for some in squares])
    return np.asarray(np.sqrt(sums / np.bincount(own)).T)
