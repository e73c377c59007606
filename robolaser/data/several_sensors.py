"""Several sensors in one data set: their `[[sensors]]`, and the rows of all of them in one table."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, final

import numpy as np
from msgspec import Meta

from robolaser.data.dataset import Dataset, Points, SensorData
from robolaser.data.joining import stacked_points
from robolaser.data.toml_schema import refused, typed, wrong
from robolaser.errors import DataError

FILE = "dataset.toml"
TABLES = ("scanner", "image", "board", "target", "noise")
"""Tables of dataset.toml that a sensor may have itself, as `[sensors.noise]`; else those of all apply."""
CORNERS = "corners.csv"  # file of `extract` with the corners in a stripe scanner's images
USUAL_M_PER_PX = 1e-4  # size of a pixel where no pose has points that show it

Name = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_-]+$")]


@final
@dataclass(frozen=True)
class SensorEntry:
    """Keys of one of `[[sensors]]` other than those of its kind."""

    name: Name
    points: Annotated[str, Meta(min_length=1)]
    kind: str = "stripe"
    camera: Name | None = None
    target: Name | None = None


def described_members(
    contents: Mapping[str, Any], described: Callable[[dict[str, Any]], Dataset]
) -> tuple[SensorData, ...]:
    """The sensors of a data set, stripe scanners first: camera and images are theirs.

    By the contents of dataset.toml; `described` reads those of a data set of one sensor.
    """
    entries = contents["sensors"]
    if "sensor" in contents:
        raise refused(FILE, "[[sensors]]", "there is [sensor], too. Keep the one or the other.")
    if not isinstance(entries, list) or len(entries) < 2 or not all(isinstance(entry, dict) for entry in entries):
        raise wrong(FILE, ("sensors",), entries, "two or more tables [[sensors]]; one sensor is [sensor]")
    members = [_member(number, entry, contents, described) for number, entry in enumerate(entries)]
    for key, values in (("name", [one.name for one in members]), ("points", [one.file for one in members])):
        for number, value in enumerate(values):
            if value in values[:number]:
                raise wrong(FILE, ("sensors", number, key), value, "different ones for all sensors")
    return _with_cameras(sorted(members, key=lambda one: "scanner" not in one.data.format.tables))


def _member(
    number: int, entry: dict[str, Any], contents: Mapping[str, Any], described: Callable[[dict[str, Any]], Dataset]
) -> SensorData:
    tables = {key: value for key, value in entry.items() if key in TABLES and isinstance(value, dict)}
    own = {key: value for key, value in entry.items() if key in SensorEntry.__annotations__ and key not in tables}
    read = typed(own, SensorEntry, file=FILE, at=("sensors", number))
    kind = {key: value for key, value in entry.items() if key not in own and key not in tables}
    shared = {key: value for key, value in contents.items() if key not in ("sensors", "parameters", *tables)}
    try:
        one = described({**shared, **tables, "sensor": {"kind": read.kind, **kind}})
    except DataError as error:
        raise DataError(f"{error} (sensor {read.name})", file=FILE, column=f"[[sensors]] {read.name}") from None
    return SensorData(read.name, one, read.points, read.camera or "", read.target or "target")


def _with_cameras(members: Sequence[SensorData]) -> tuple[SensorData, ...]:
    """Unnamed cameras have their sensor's name, that of an only scanner "camera": none is shared unless it is named."""
    scanners = [one.name for one in members if one.data.kind != "camera" and "pixel" in one.data.format.columns]

    def named(one: SensorData) -> str:
        return one.name if one.data.kind == "camera" or (one.name in scanners and len(scanners) > 1) else "camera"

    return tuple(replace(one, camera=one.camera or named(one)) for one in members)


def with_points_of(dataset: Dataset, points: Sequence[Points]) -> Dataset:
    """A data set with the points of each of its sensors."""
    if not dataset.members:
        return replace(dataset, points=points[0])
    members = tuple(
        replace(member, metres_per_unit=_metres_per_unit(member.data, own))
        for member, own in zip(dataset.members, points, strict=True)
    )
    return replace(dataset, members=members, points=_joined([member.name for member in members], points))


def scanner_with_corners(scanner: Dataset, corners: Points) -> Dataset:
    """A stripe scanner's data set with the board's corners in its images: two sensors, `stripe` and `camera`."""
    poses, points = scanner.poses.take(np.arange(0)), scanner.points.take(slice(0, 0))
    alone = replace(scanner, poses=poses, points=points, robot=None, sessions=None, parameters={}, warnings=())
    camera = replace(alone, kind="camera", options=None, noise=replace(alone.noise, pixel_px=None))
    members = (
        SensorData("stripe", alone, "points.csv", camera="camera", target="target"),
        SensorData("camera", camera, CORNERS, camera="camera", target="target"),
    )
    return with_points_of(replace(scanner, members=members), [scanner.points, corners])


def _joined(names: Sequence[str], points: Sequence[Points]) -> Points:
    widths = {name: values.shape[1] for one in points for name, values in one.arrays.items()}
    parts = []
    for number, (sensor, one) in enumerate(zip(names, points, strict=True)):
        arrays = {name: one.arrays.get(name, np.zeros((len(one), width))) for name, width in widths.items()}
        named = tuple(f"{sensor}/{point}" for point in one.names)
        parts.append(replace(one, names=named, sensor=np.full(len(one), number)).with_arrays(arrays))
    return stacked_points(parts)


def _metres_per_unit(described: Dataset, points: Points) -> float:
    """Typical size of a pixel on the target: spreads of its points in metres and in pixels, pose by pose."""
    if described.format.unit != "px":
        return 1.0
    ratios = []
    order = np.argsort(points.pose, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(points.pose[order])) + 1) if len(order) else ():
        spread_m, spread_px = (
            float(np.linalg.norm(values[rows].std(axis=0))) for values in (points["xyz"], points["pixel"])
        )
        if spread_px > 0.0 and spread_m > 0.0:
            ratios.append(spread_m / spread_px)
    return float(np.median(ratios)) if ratios else USUAL_M_PER_PX
