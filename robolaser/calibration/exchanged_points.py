"""Points of one pose whose names were exchanged: what they are apart from each other says so, whatever the arm does."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset

MOST_NAMES: Final = 6
"""Names of which all orders are tried."""
FAR: Final = 10.0
"""Times the usual deviation of a distance, from which a pose's distances are others, and below which they fit."""
LEAST_M: Final = 2e-4
"""The same at least. A judgement: distances on a tool differ by millimetres, trackers err by less."""


def exchanged_points(dataset: Dataset) -> Mapping[int, Mapping[str, str]]:
    """What points of some poses are called, and should be: those on one rigid body keep their distances.

    Args:
        dataset: With points that a tracker measured; nothing is said of others, nor where distances are alike.
    """
    points = dataset.points
    names = list(dict.fromkeys(points.names))
    if points.xyz is None or points.pixel is not None or not 2 < len(names) <= MOST_NAMES or points.columns:
        return {}
    number = np.array([names.index(name) for name in points.names])
    cells = points.pose * len(names) + number
    size = len(dataset.poses) * len(names)
    count = np.bincount(cells, minlength=size)
    sums = np.stack([np.bincount(cells, axis, minlength=size) for axis in points.xyz.T], axis=-1)
    places = np.where(count[:, None] > 0, sums / np.maximum(count, 1)[:, None], np.nan).reshape(-1, len(names), 3)
    apart = np.linalg.norm(places[:, :, None] - places[:, None], axis=-1)
    whole = np.isfinite(apart).all(axis=(1, 2))
    if whole.sum() < 2 * MOST_NAMES:
        return {}
    usual = np.median(apart[whole], axis=0)
    off = np.abs(apart - usual).max(axis=(1, 2))
    enough = max(FAR * float(np.median(off[whole])), LEAST_M)
    if enough > _least_between(usual):
        return {}
    orders = [list(order) for order in permutations(range(len(names)))]
    found: dict[int, Mapping[str, str]] = {}
    for pose in np.flatnonzero(whole & (off > enough)).tolist():
        misfits = [np.abs(apart[pose][np.ix_(order, order)] - usual).max() for order in orders]
        if min(misfits) <= enough:
            order = orders[int(np.argmin(misfits))]
            found[pose] = {names[was]: names[i] for i, was in enumerate(order) if was != i}
    return found


def _least_between(usual: Array) -> float:
    """How far two distances of a body differ at least [m]: where some are alike, an exchange changes nothing."""
    distances = np.sort(usual[np.triu_indices(len(usual), 1)])
    return float(np.diff(distances).min())


def with_names(dataset: Dataset, names: Mapping[int, Mapping[str, str]]) -> Dataset:
    """The data set with points of some poses called otherwise."""
    points = dataset.points
    called = zip(points.pose.tolist(), points.names, strict=True)
    right = tuple(names.get(pose, {}).get(name, name) for pose, name in called)
    return replace(dataset, points=replace(points, names=right))


def fault_text(names: Mapping[int, Mapping[str, str]], poses: Sequence[str], most: int = 4) -> str:
    """The beginning of a sentence: which points of which poses."""
    which = ", ".join(sorted({name for one in names.values() for name in one}))
    where = [poses[pose] for pose in names]
    listed = ", ".join(where[:most]) + (" and others" if len(where) > most else "")
    return f"The points {which} of pose{'s' if len(where) > 1 else ''} {listed} seem to be exchanged"
