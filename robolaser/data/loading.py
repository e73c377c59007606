"""A data set read from its folder, and checked."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from robolaser.data import data_tables
from robolaser.data.csv_tables import read_table
from robolaser.data.data_tables import points_of, read_poses, some
from robolaser.data.dataset import Dataset, Points, Poses, SensorData
from robolaser.data.dataset_file import FILE, describe, inside
from robolaser.data.path_velocities import with_path_velocities
from robolaser.data.sessions import FEWEST_POSES, Sessions
from robolaser.data.several_sensors import with_points_of
from robolaser.data.toml_schema import lacking, refused, wrong


def load(folder: str | Path) -> Dataset:
    """Read and check a data set.

    Args:
        folder: Holds dataset.toml, poses.csv and, once there are points, points.csv.

    Raises:
        DataError: Names file, row and column of the fault.
        RobotError: The URDF, its flange or its joints are not usable.
    """
    folder = Path(folder)
    described = describe(folder)
    poses, odd = read_poses(folder / data_tables.FILE, described.robot)
    dataset = with_path_velocities(
        replace(described, poses=poses, sessions=_sessions(described, poses), warnings=(*described.warnings, *odd))
    )
    files = [inside(folder, sensor.file, f"{FILE}, [[sensors]] points") for sensor in dataset.sensors]
    if not any(file.exists() for file in files):
        return dataset
    seen = [_points(folder, sensor.data, sensor.file) for sensor in dataset.sensors]
    _check_distances(dataset.sensors, seen)
    dataset = with_points_of(dataset, seen)
    _check_sessions(dataset)
    return replace(dataset, warnings=(*dataset.warnings, *_silent(dataset), *_copies(dataset)))


def _points(folder: Path, dataset: Dataset, file: str) -> Points:
    columns = [column for group in dataset.format.columns.values() for column in group]
    points = points_of(read_table(folder / file, ["repeat", *columns]), dataset)
    _check_radii(dataset, sorted(set(points.names)), file)
    return points


def _check_distances(sensors: Sequence[SensorData], seen: Sequence[Points]) -> None:
    """Check that known distances are between two points of one of the sensors for which they are stated."""
    named: dict[tuple[int, tuple[str, str, float]], list[set[str]]] = {}
    for sensor, points in zip(sensors, seen, strict=True):
        for entry in enumerate(sensor.data.distances_m):
            named.setdefault(entry, []).extend([set(points.names)] if sensor.data.format.named_points else [])
    for (number, (one, other, distance)), names in named.items():
        if not names:
            why = (
                f"the points of a {sensors[0].data.format.title} have no names, so that no distance between"
                " two of them can be known. Delete it."
            )
            raise refused(FILE, "[target] distances_m", why)
        if one == other or not any({one, other} <= own for own in names):
            known = ", ".join(sorted(set().union(*names))) or "none"
            expected = f"[point, another point, distance in m], points among: {known}"
            raise wrong(FILE, ("target", "distances_m", number), [one, other, distance], expected)


def _check_radii(dataset: Dataset, balls: list[str], file: str) -> None:
    missing = [ball for ball in balls if ball not in dataset.radius_m]
    if dataset.format.balls and missing:
        on = f"{file} has points on {'balls of these names' if len(missing) > 1 else 'a ball of this name'}"
        how = f"State the radius of each ball in metres, as in radius_m = {{ {missing[0]} = 0.0127 }}"
        raise lacking(FILE, f"[target] radius_m of {', '.join(missing)}", f": {on}. {how}")


def _sessions(described: Dataset, poses: Poses) -> Sessions | None:
    if poses.session is None:
        if described.sessions is not None:
            how = "Add the column, with the name of each pose's campaign, or delete [sessions]"
            raise lacking(data_tables.FILE, "column session", f", but {FILE} has [sessions]. {how}")
        return None
    names = tuple(dict.fromkeys(poses.session))
    return Sessions(names) if described.sessions is None else replace(described.sessions, names=names)


def _check_sessions(dataset: Dataset) -> None:
    if dataset.sessions is None:
        return
    seen = dataset.session_of_pose[np.unique(dataset.points.pose)]
    counts = np.bincount(seen, minlength=len(dataset.sessions.names))
    for name, count in zip(dataset.sessions.names, counts.tolist(), strict=True):
        if count < FEWEST_POSES:
            few = f"'{name}' has {count} pose{'s' * (count != 1)} with points, but a session needs at least"
            how = f"{FEWEST_POSES}. Is the name misspelt? Otherwise measure more poses, or delete these."
            raise refused(data_tables.FILE, "column session", f"{few} {how}")


def _silent(dataset: Dataset) -> list[str]:
    """A warning of poses without points, except those without an image in a recording, which an arm only passed."""
    rows = np.bincount(dataset.points.pose, minlength=len(dataset.poses))
    images = dataset.poses.image
    silent = [dataset.poses.names[i] for i in np.flatnonzero(rows == 0) if images is None or images[i]]
    return [f"{len(silent)} of {len(dataset.poses)} poses have no points: {some(silent)}."] if silent else []


def _copies(dataset: Dataset) -> list[str]:
    """A warning of poses that repeat the readings and points of another under a new name."""
    poses, points = dataset.poses, dataset.points
    readings = dataset.flange() if poses.q is None else poses.q
    _, number, counts = np.unique(readings.reshape(len(poses), -1), axis=0, return_inverse=True, return_counts=True)
    ends = np.cumsum(np.bincount(points.pose, minlength=len(poses)))
    rows = np.split(np.argsort(points.pose, kind="stable"), ends[:-1])
    first: dict[object, int] = {}
    copies = []
    for pose in np.flatnonzero(counts[number] > 1).tolist():
        seen = points.take(rows[pose])
        key = number[pose], seen.names, *(values.tobytes() for values in seen.arrays.values())
        if len(seen) and first.setdefault(key, pose) != pose:
            copies.append(f"{poses.names[pose]} (of {poses.names[first[key]]})")
    if not copies:
        return []
    return [
        f"{len(copies)} of {len(poses)} poses are copies of others, readings and points alike: {some(copies)}. They say"
        " nothing new; delete them."
    ]
