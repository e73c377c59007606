"""Exchanged images or poses: rows far off at their own poses that fit at each other's."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.misread import FALLS, millimetres
from robolaser.calibration.result import Calibration, rms, rms_of_poses
from robolaser.data.dataset import Dataset
from robolaser.estimation.plain_fit import fit
from robolaser.model.forward_model import Model, of_data

FAR: Final = 2.0
"""Times the median error above which a pose is far off, and factor by which its rows must fit better elsewhere."""
MOST_FAR: Final = 20  # of them, the worst: each is tried at each other's place
FITS: Final = 3.0
"""Times the error of all other poses up to which rows fit. A judgement: for exchanged poses it is in the hundreds."""


def seem_exchanged(model: Model, x: Array, errors_m: Array) -> Mapping[int, int]:
    """For each exchanged pose, the pose where its rows fit.

    By the model of all rows at x (d,) and its errors, (m, j) [m].
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
    """Whether exchanged rows fit as well as all others after a fit with them at the poses where they belong.

    If all others are centimetres off, something else is wrong.

    Args:
        belongs: The poses.
        model: The model of the rows as read.
        as_read_m: Errors of its fit, (m, j) [m].
        moved_m: Errors of a fit with rows moved, (m, j) [m].
    """
    moved = np.isin(model.dataset.points.pose, list(belongs))
    others = rms(moved_m[~moved])
    return others < SETUP_RMS_M and rms(moved_m[moved]) < min(FITS * others, rms(as_read_m[moved]) / FALLS)


def exchanged_warning(found: Calibration) -> str:
    """A sentence on exchanged poses, with the error without that; empty if there are none."""
    model = found.model
    if not (belongs := seem_exchanged(model, found.x, found.errors_m)):
        return ""
    right = Model(with_rows_at(model.dataset, belongs), model.effects)
    x = fit(right, found.x)[1]
    errors_m = right.in_metres(x, right.residuals(x[None])[0])
    if not belong_there(belongs, model, found.errors_m, errors_m):
        return ""
    error = f"the error is {millimetres(rms(errors_m))} instead of {millimetres(found.rms_m)}"
    return f"{exchanged(belongs, model.dataset.poses.names)}: with that corrected, {error}. Correct the data set."


def exchanged(belongs: Mapping[int, int], names: Sequence[str]) -> str:
    """A clause on exchanged poses, by the right pose of the rows of each and the names of all poses."""
    text = [
        f"{names[a]} and {names[b]} are exchanged" if belongs[b] == a else f"{names[a]} belong to pose {names[b]}"
        for a, b in belongs.items()
        if a < b or belongs[b] != a
    ]
    return f"The points (or images) of poses {', and '.join(text)}"


def _errors_at_each_other(model: Model, x: Array, far: Ints) -> Array:
    """Root-mean-square error of all rows of each pose at each of them, (f, f) [m]."""
    points, f = model.dataset.points, len(far)
    own, rows = np.nonzero(points.pose == far[:, None])
    moved = replace(points.take(np.tile(rows, f)), pose=np.repeat(far, len(rows)))
    there = of_data(model, replace(model.dataset, points=moved))
    squares = np.square(there.in_metres(x, there.residuals(x[None])[0])).sum(axis=-1).reshape(f, -1)
    sums = np.array([np.bincount(own, some) for some in squares])
    return np.asarray(np.sqrt(sums / np.bincount(own)).T)
