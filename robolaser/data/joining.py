"""Data sets of one arm joined into one, with a session each, or as poses that followed others."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from itertools import chain
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.same_arm import check_same_arm
from robolaser.data.sessions import OWN, Sessions
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError
from robolaser.parameters import Parameter

A = TypeVar("A", bound=np.generic)


def join_sessions(datasets: Mapping[str, Dataset], *, name: str, own: tuple[str, ...] = OWN) -> Dataset:
    """Join campaigns of one arm and sensor into one data set.

    What all share is taken from the first; of stated noise, the largest. Columns that one of them lacks are dropped.
    Where pose names come twice, the session's name is put before them.

    Args:
        datasets: By the name of their session.
        name: Of the whole.
        own: Parameters of which each session has a copy, see `Sessions`.

    Raises:
        DataError: They are not of one arm and one kind of sensor.
    """
    first, *others = datasets.values()
    for other in others:
        check_same_arm(first, other, f"joined with {first.name}")
    sessions = Sessions(tuple(datasets), own)
    every = [first, *others]
    return replace(
        first,
        name=name,
        poses=_poses(datasets),
        points=_points(every),
        parameters=_parameters(datasets, sessions),
        distances_m=tuple(dict.fromkeys(chain.from_iterable(one.distances_m for one in every))),
        radius_m={name: radius for one in every for name, radius in one.radius_m.items()},
        noise=_largest([one.noise for one in every]),
        time_is_order=any(one.time_is_order for one in every),
        path_known=all(one.path_known for one in every),
        warnings=(),
        folder=None,
        sessions=sessions,
    )


def with_poses_of(dataset: Dataset, further: Dataset) -> Dataset:
    """A data set with poses that were measured after its own, and their points.

    Raises:
        DataError: They are not of one arm and one kind of sensor, or two poses have one name.
    """
    check_same_arm(dataset, further, f"appended to {dataset.name}")
    names = (*dataset.poses.names, *further.poses.names)
    if len(set(names)) < len(names):
        twice = sorted(set(dataset.poses.names) & set(further.poses.names))
        raise DataError(f"Pose {twice[0]} is in both data sets: give the further poses names of their own.")
    sessions = [one.poses.session for one in (dataset, further)]
    session = None if None in sessions else tuple(chain.from_iterable(one or () for one in sessions))
    poses = replace(_poses({"": dataset, "further": further}), names=names, session=session)
    return replace(dataset, poses=poses, points=_points([dataset, further]))


def poses_beyond(dataset: Dataset, longer: Dataset) -> Dataset | None:
    """The poses of a longer data set that are not in one with which it begins; None where it does not begin so."""
    n, rows = len(dataset.poses), len(dataset.points)
    if len(longer.poses) < n or len(longer.points) < rows or (longer.points.pose[rows:] < n).any():
        return None
    poses, some = longer.poses.take(np.arange(n)), longer.points.take(slice(rows))
    pairs = [
        (poses.q, dataset.poses.q),
        (poses.T_base_flange, dataset.poses.T_base_flange),
        (some.pose, dataset.points.pose),
        (some.pixel, dataset.points.pixel),
        (some.xyz, dataset.points.xyz),
        *((some.columns.get(name), values) for name, values in dataset.points.columns.items()),
    ]
    names = (poses.names, some.names) == (dataset.poses.names, dataset.points.names)
    if not names or not all(_equal(*pair) for pair in pairs):
        return None
    return longer.of_poses(np.arange(len(longer.poses)) >= n)


def _equal(one: NDArray[A] | None, other: NDArray[A] | None) -> bool:
    return one is other or (one is not None and other is not None and np.array_equal(one, other))


def _poses(datasets: Mapping[str, Dataset]) -> Poses:
    poses = [one.poses for one in datasets.values()]
    names = list(chain.from_iterable(one.names for one in poses))
    session = tuple(session for session, one in datasets.items() for _ in one.poses.names)
    if len(set(names)) < len(names):
        names = [f"{at}/{name}" for at, name in zip(session, names, strict=True)]
    columns = [column for column in poses[0].extra if all(column in one.extra for one in poses)]
    images = [one.image for one in poses]
    return Poses(
        tuple(names),
        time_s=_all([one.time_s for one in poses]),
        q=_all([one.q for one in poses]),
        qd=_all([one.qd for one in poses]),
        qd_from_path=any(one.qd_from_path for one in poses),
        T_base_flange=_all([one.T_base_flange for one in poses]),
        image=None if None in images else tuple(chain.from_iterable(image or () for image in images)),
        payload_kg=_all([one.payload_kg for one in poses]),
        temperature_c=_all([one.temperature_c for one in poses]),
        session=session,
        following={
            joint: np.concatenate([one.following[joint] for one in poses])
            for joint in poses[0].following
            if all(joint in one.following for one in poses)
        },
        extra={column: tuple(chain.from_iterable(one.extra[column] for one in poses)) for column in columns},
    )


def _points(datasets: Sequence[Dataset]) -> Points:
    points = [one.points for one in datasets]
    before = np.cumsum([0, *(len(one.poses) for one in datasets)])
    repeats = None if any(one.repeat is None for one in points) else [one.repeat for one in points]
    return Points(
        np.concatenate([one.pose + n for one, n in zip(points, before[:-1], strict=True)]),
        tuple(chain.from_iterable(one.names for one in points)),
        repeat=None if repeats is None else np.concatenate([one for one in repeats if one is not None]),
        pixel=_all([one.pixel for one in points]),
        xyz=_all([one.xyz for one in points]),
        columns={column: np.concatenate([one.columns[column] for one in points]) for column in points[0].columns},
        sensor=_all([one.sensor for one in points]),
    )


def _all(arrays: Sequence[NDArray[A] | None]) -> NDArray[A] | None:
    known = [array for array in arrays if array is not None]
    return np.concatenate(known) if len(known) == len(arrays) else None


def _parameters(datasets: Mapping[str, Dataset], sessions: Sessions) -> Mapping[str, Parameter]:
    found: dict[str, Parameter] = {}
    for session, dataset in datasets.items():
        for item in dataset.parameters.values():
            name = sessions.named(item.name, session)
            found.setdefault(name, replace(item, name=name))
    return found


def _largest(noises: Sequence[Noise]) -> Noise:
    stated = [{name: sigma for name, sigma in asdict(noise).items() if sigma is not None} for noise in noises]
    common = set.intersection(*map(set, stated))
    return Noise(**{name: max(one[name] for one in stated) for name in common})
