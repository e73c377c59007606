"""Subsampling of rows: evenly, or by poses spread over time and configurations."""

from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset

MAX_POSES = 300  # poses with rows for the search of effects: one that needs more is far too small to matter
MAX_ROWS = 4000  # rows that are kept, as long as each pose has a few: rows of a pose share most of their errors
MIN_ROWS = 3  # of each pose, where it has as many: enough to distinguish a stripe's shift from its tilt


def evenly(count: int, most: int) -> Ints:
    """Indices of at most so many out of `count` items, with the first and the last, (k,)."""
    return np.asarray(np.linspace(0, max(count - 1, 0), min(count, most)).round().astype(np.int64))


def rows_of_each(group: Ints, most: int) -> Ints:
    """The rows that `some_of_each` takes, in their order, (k,)."""
    table = some_of_each(group, most)
    return np.sort(table[table >= 0])


def some_of_each(group: Ints, most: int) -> Ints:
    """At most so many rows of each group (m,), evenly taken along them, (groups, most); -1 where it has fewer."""
    order = np.argsort(group, kind="stable")
    counts = np.bincount(group)
    starts = (np.cumsum(counts) - counts)[counts > 0, None]
    counts = counts[counts > 0, None]
    most = min(most, int(counts.max(initial=0)))
    taken, index = np.minimum(most, counts), np.arange(most)
    last = (index > 0) & (index == taken - 1)
    along = np.where(last, counts - 1, index * ((counts - 1) / np.maximum(taken - 1, 1)))
    rows = order[np.minimum(starts + along.round().astype(np.int64), len(order) - 1)]
    return np.where(index < taken, rows, -1)


def subsampled(dataset: Dataset, most: int) -> Dataset:
    """The same data set with at most about `most` points, every pose or, where points have names, every name kept.

    At least three rows of each pose or name are kept, evenly taken along them.
    """
    points, sensors = dataset.points, dataset.sensors
    chosen = []
    for sensor in sensors:
        group = (points.number if sensor.data.format.named_points else points.pose)[sensor.rows]
        share = most // len(sensors) // max(1, len(np.unique(group)))
        chosen.append(sensor.rows[rows_of_each(group, max(MIN_ROWS, share))])
    kept = np.sort(np.concatenate(chosen))
    if len(kept) == len(points):
        return dataset
    return replace(dataset, points=points.take(kept), whole=dataset.whole or dataset)


def chosen_rows(dataset: Dataset, seed: int, most: int = MAX_POSES) -> Bools:
    """Mark rows of about so many poses that are spread over time and configurations, (m,).

    Where names mean the same point at every pose, whole poses are kept; else rows evenly taken along those of each
    pose. Where each pose shows one named point only, there are as many poses of each name. The seed chooses among poses
    that are near each other.
    """
    points = dataset.points
    chosen = _some(dataset, seed, most)
    kept = np.zeros(len(points), dtype=bool)
    for sensor in dataset.sensors:
        rows = sensor.rows[np.isin(points.pose[sensor.rows], chosen)]
        if not sensor.data.format.named_points and len(rows):
            most = max(MIN_ROWS, MAX_ROWS // len(dataset.sensors) // len(chosen))
            rows = rows[rows_of_each(points.pose[rows], most)]
        kept[rows] = True
    return kept


def _some(dataset: Dataset, seed: int, most: int) -> Ints:
    """At most about so many of the poses with rows, as many of each name that is the only one in its poses."""
    poses, first = np.unique(dataset.points.pose, return_index=True)
    if len(poses) <= most:
        return poses
    name = dataset.points.number[first] if _one_name_a_pose(dataset) else np.zeros(len(poses), dtype=np.int64)
    names, counts = np.unique(name, return_counts=True)
    places, rng = _coordinates(dataset)[poses], np.random.default_rng(seed)
    own = [np.flatnonzero(name == one) for one in names]
    shares = [max(1, int(share)) for share in _shares(counts, most)]
    return np.sort(poses[np.concatenate([_spread(places, *one, rng) for one in zip(own, shares, strict=True)])])


def _one_name_a_pose(dataset: Dataset) -> bool:
    """Whether names mean the same point at every pose, and each pose shows one of them."""
    if not dataset.format.named_points or dataset.format.many_rows:
        return False
    shown = np.unique(np.stack([dataset.points.pose, dataset.points.number]), axis=1)[0]
    return len(shown) == len(np.unique(shown))


def _shares(counts: Ints, most: int) -> Ints:
    """Numbers kept of each group (g,): equal ones, or all of a smaller group."""
    shares, left = np.zeros_like(counts), most
    for number, i in enumerate(np.argsort(counts, kind="stable")):
        shares[i] = min(counts[i], left // (len(counts) - number))
        left -= shares[i]
    return shares


def _coordinates(dataset: Dataset) -> Array:
    """Time, configuration and further coordinates of each pose, each from 0 to 1, (n, d)."""
    poses, n = dataset.poses, len(dataset.poses)
    configuration = poses.q if poses.q is not None else dataset.flange()[:, :3].reshape(n, -1)
    when = np.arange(float(n)) if poses.time_s is None else poses.time_s
    places = np.column_stack([when, configuration, *poses.coordinates.values()])
    width = np.ptp(places, axis=0)
    return np.asarray((places - places.min(axis=0)) / np.where(width > 0, width, 1.0))


def _spread(places: Array, among: Ints, most: int, rng: np.random.Generator) -> Ints:
    """So many of some positions (n, d), one of each cell: cells are halved across their longest side."""
    if most >= len(among):
        return among
    if most == 1:
        return rng.choice(among, 1)
    side = int(np.argmax(np.ptp(places[among], axis=0)))
    order = among[np.argsort(places[among, side], kind="stable")]
    half = most // 2
    at = round(len(order) * half / most)
    return np.concatenate([_spread(places, order[:at], half, rng), _spread(places, order[at:], most - half, rng)])


def kept_poses(dataset: Dataset) -> Bools:
    """Mark poses with rows, and those at the ends of time and of further coordinates, (n,)."""
    poses = dataset.poses
    kept = np.bincount(dataset.points.pose, minlength=len(poses)) > 0
    measured = list(poses.coordinates.values())
    if poses.time_s is not None:
        measured.append(poses.time_s)
    session = dataset.session_of_pose
    for poses_of in (np.flatnonzero(session == number) for number in np.unique(session)):
        for values in measured:
            kept[poses_of[[int(np.argmin(values[poses_of])), int(np.argmax(values[poses_of]))]]] = True
    return kept
