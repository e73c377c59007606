"""Data sets of one arm joined into one, with a session each, or as further poses; and their comparison."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from robolaser.data.csv_tables import RowTable
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.sessions import OWN, Sessions
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError
from robolaser.parameters import Parameter

SAME = 1e-6  # [m, and of rotation matrices] URDFs that round their digits differ by less


def join_sessions(datasets: Mapping[str, Dataset], *, name: str, own: tuple[str, ...] = OWN) -> Dataset:
    """Join campaigns of one arm and sensor into one data set.

    Shared properties are those of the first; stated noise is the largest. Columns that one of them lacks are dropped.
    Repeated pose names get the session's name as a prefix.

    Args:
        datasets: By the name of their session.
        name: Of the whole.
        own: Parameters of which each session has a copy, see `Sessions`.

    Raises:
        DataError: They are not of one arm and one kind of sensor, or one of them has several sessions already.
    """
    first, *others = every = list(datasets.values())
    for other in others:
        check_same_arm(first, other, f"joined with {first.name}")
    for one in every:
        if one.sessions is not None and len(one.sessions.names) > 1:
            names = ", ".join(one.sessions.names)
            raise DataError(f"{one.name} is several sessions already: {names}. Join the data set of each of them.")
    sessions = Sessions(tuple(datasets), own)
    return replace(
        first,
        name=name,
        poses=_poses(datasets),
        points=_points(every),
        parameters=_parameters(datasets, sessions),
        members=tuple(
            replace(member, data=replace(member.data, **_known([one.members[i].data for one in every])))
            for i, member in enumerate(first.members)
        ),
        **_known(every),
        time_is_order=any(one.time_is_order for one in every),
        path_known=all(one.path_known for one in every),
        warnings=(),
        folder=None,
        sessions=sessions,
    )


def with_poses_of(dataset: Dataset, further: Dataset) -> Dataset:
    """A data set with poses that were measured after its own, and their points."""
    check_same_arm(dataset, further, f"appended to {dataset.name}")
    sessions = [one.poses.session for one in (dataset, further)]
    if None in sessions and any(sessions):
        raise DataError(f"Only one of {dataset.name} and {further.name} states the session of each pose.")
    names = (*dataset.poses.names, *further.poses.names)
    if len(set(names)) < len(names):
        twice = sorted(set(dataset.poses.names) & set(further.poses.names))
        raise DataError(f"Pose {twice[0]} is in both data sets: rename the further ones.")
    session = tuple(chain.from_iterable(one or () for one in sessions)) or None
    poses = replace(_poses({"": dataset, "further": further}), names=names, session=session)
    known = dataset.sessions
    if known is not None:
        known = replace(known, names=tuple(dict.fromkeys((*known.names, *(session or ())))))
    return replace(dataset, poses=poses, points=_points([dataset, further]), sessions=known)


def poses_beyond(dataset: Dataset, longer: Dataset) -> Dataset | None:
    """The poses of a longer data set after those of the shorter one; None where it does not begin with these."""
    old = np.arange(len(longer.poses)) < len(dataset.poses)
    if len(longer.poses) < len(dataset.poses) or _measured(longer.of_poses(old)) != _measured(dataset):
        return None
    return longer.of_poses(~old)


def _measured(dataset: Dataset) -> str:
    """A digest of readings and points, without velocities by differences, of which the last changes."""
    poses = replace(dataset.poses, qd=None) if dataset.poses.qd_from_path else dataset.poses
    return fingerprint(replace(poses, qd_from_path=False), dataset.points)


def check_same_arm(one: Dataset, other: Dataset, purpose: str) -> None:
    """Check that two data sets are of one arm and one kind of sensor; the second is at fault where they differ.

    The purpose is for the message: the second cannot be "predicted with what is found on cell".

    Raises:
        DataError: They are not; with the difference.
    """
    differs = next(_differences(one, other), None)
    if differs:
        raise DataError(
            f"{other.name} cannot be {purpose}: {differs}. Both must be of the same arm, with the same joints, flange"
            " and kind of sensor.",
            file=other.folder or other.name,
        )


def _poses(datasets: Mapping[str, Dataset]) -> Poses:
    names = [name for one in datasets.values() for name in one.poses.names]
    session = tuple(session for session, one in datasets.items() for _ in one.poses.names)
    if len(set(names)) < len(names):
        names = [f"{at}/{name}" for at, name in zip(session, names, strict=True)]
    return replace(stacked([one.poses for one in datasets.values()]), names=tuple(names), session=session)


def _points(datasets: Sequence[Dataset]) -> Points:
    """Points of all data sets, with pose numbers of the joined one."""
    before = np.cumsum([0, *(len(one.poses) for one in datasets)])[:-1]
    return stacked_points(
        [replace(one.points, pose=one.points.pose + n) for one, n in zip(datasets, before, strict=True)]
    )


def stacked_points(parts: Sequence[Points]) -> Points:
    """The rows of all parts; shots without a number are the first."""
    if any(one.repeat is not None for one in parts):
        parts = [one if one.repeat is not None else replace(one, repeat=np.zeros(len(one), np.int64)) for one in parts]
    return stacked(parts)


def stacked(parts: Sequence[RowTable]) -> RowTable:
    """The rows of all parts, with their common columns."""

    def joined(columns: Sequence[Any]) -> Any:
        first = columns[0]
        if any(one is None for one in columns):
            return None
        if isinstance(first, Mapping):
            common = [name for name in first if all(name in one for one in columns)]
            return {name: joined([one[name] for one in columns]) for name in common}
        if isinstance(first, tuple):
            return tuple(chain.from_iterable(columns))
        return np.concatenate(columns) if isinstance(first, np.ndarray) else any(columns)

    names = [one.name for one in fields(parts[0])]
    return type(parts[0])(**{name: joined([getattr(one, name) for one in parts]) for name in names})


def _parameters(datasets: Mapping[str, Dataset], sessions: Sessions) -> Mapping[str, Parameter]:
    found: dict[str, Parameter] = {}
    for session, dataset in datasets.items():
        for item in dataset.parameters.values():
            name = sessions.named(item.name, session)
            found.setdefault(name, replace(item, name=name))
    return found


def _known(datasets: Sequence[Dataset]) -> dict[str, Any]:
    """Stated noise and target of all data sets together; of two radii, the first."""
    return {
        "distances_m": tuple(dict.fromkeys(chain.from_iterable(one.distances_m for one in datasets))),
        "radius_m": {name: radius for one in reversed(datasets) for name, radius in one.radius_m.items()},
        "noise": _largest([one.noise for one in datasets]),
    }


def _largest(noises: Sequence[Noise]) -> Noise:
    stated = [{name: sigma for name, sigma in asdict(noise).items() if sigma is not None} for noise in noises]
    return Noise(**{name: max(one[name] for one in stated) for name in set.intersection(*map(set, stated))})


def _differences(one: Dataset, other: Dataset) -> Iterator[str]:
    if one.kind != other.kind:
        yield f'[sensor] kind is "{one.kind}" in {one.name} and "{other.kind}" in {other.name}'
    mine, theirs = ([(sensor.name, sensor.data.kind) for sensor in each.sensors] for each in (one, other))
    if mine != theirs:
        yield f"[[sensors]] are {_listed(mine)} in {one.name} and {_listed(theirs)} in {other.name}"
    a, b = one.robot, other.robot
    if a is None or b is None:
        if (a is None) != (b is None):
            yield f"only {one.name if b is None else other.name} has a [robot]"
        return
    if a.joints != b.joints:
        yield f"[robot] joints are {', '.join(a.joints)} in {one.name} and {', '.join(b.joints)} in {other.name}"
        return
    if a.flange != b.flange:
        yield f'[robot] flange is "{a.flange}" in {one.name} and "{b.flange}" in {other.name}'
    first, second = a.by_pinocchio, b.by_pinocchio
    if first.moving != second.moving:
        yield f"their URDFs move {', '.join(first.moving)} and {', '.join(second.moving)}"
        return
    apart = np.abs(first.placements - second.placements).max(axis=(1, 2))
    turned = np.abs(first.axes - second.axes).max(axis=1)
    for joint in np.flatnonzero(np.maximum(apart, turned) > SAME)[:1]:
        yield f"their URDFs place {first.moving[joint]} differently"
    if max(np.abs(first.ratios - second.ratios).max(), np.abs(first.offsets - second.offsets).max()) > SAME:
        yield "in their URDFs, joints follow others (mimic) by other numbers"
    if np.abs(a.end - b.end).max() > SAME:
        yield "their URDFs place the flange differently on the last joint"


def _listed(sensors: list[tuple[str, str]]) -> str:
    return ", ".join(f"{name} ({kind})" for name, kind in sensors) or "not there"


WORDS = frozenset({"name", "source", "licence", "folder", "warnings"})
"""Fields that describe a data set and its folder, without influence on residuals."""


def fingerprint(*values: Any) -> str:
    """A digest of data sets, dataclasses, mappings, sequences, arrays, texts and numbers, 64 hexadecimal digits.

    All fields of a data set count except `WORDS` and derived ones (`compare=False`), so new fields are included
    without a change here.
    """
    return _digest(repr(_plain(values)).encode())


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _plain(value: Any) -> Any:
    """Equivalent lists, dictionaries and texts."""
    if isinstance(value, np.ndarray):
        return [value.dtype.str, value.shape, _digest(value.tobytes())]
    if is_dataclass(value) and not isinstance(value, type):
        names = [one.name for one in fields(value) if one.compare]
        uncounted = WORDS if {"poses", "points"} <= set(names) else frozenset()
        return [type(value).__name__, _plain({name: getattr(value, name) for name in names if name not in uncounted})]
    if isinstance(value, Mapping):
        return {name: _plain(value[name]) for name in sorted(value)}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(one) for one in value]
    return value
