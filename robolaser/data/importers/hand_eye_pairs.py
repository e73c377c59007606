"""Pairs of flange pose and target pose in the camera, as a data set of 6-D poses: A X = X B and A X = Z B."""

import re
from dataclasses import dataclass, replace
from typing import Final, cast, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points, Poses, SensorData
from robolaser.data.importers.importer import Imported, ImportOptions
from robolaser.data.sensor_format import POSE_UNITS, Mount
from robolaser.data.several_sensors import with_points_of
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import from_quaternion, inverse, pose, to_angles, to_quaternion
from robolaser.parameters import Parameter

MOUNTS: tuple[Mount, ...] = ("flange", "base")
MOUNT: Final = "mount"  # option with the camera's mount
BODIES: dict[Mount, str] = {"flange": "camera", "base": "target"}  # the body on the flange, whose poses are measured
SPAN = {"m": 1.0, "rad": np.pi}  # largest error of a start value


@final
@dataclass(frozen=True)
class Pairs:
    """Imported pairs, one entry a pose (n)."""

    file: str  # their file
    poses: Poses  # of the flange, or joint readings in the order of the robot's
    T_camera_target: Array  # measured by the camera, (n, 4, 4)
    flange_from: str  # source field of the flange's pose or the joint readings
    target_from: str  # source field of the target's pose
    guess: Array | None = None  # T_flange_camera or T_base_camera by another tool, (4, 4)


def flange_poses(T_base_flange: Array) -> Poses:
    """Poses of the flange (n, 4, 4), numbered from 1."""
    return Poses(tuple(str(i) for i in range(1, len(T_base_flange) + 1)), T_base_flange=T_base_flange)


def mount_of(options: ImportOptions, file: str, known: Mount | None = None) -> Mount:
    """The camera's mount, by the file or the user."""
    stated = options.further.get(MOUNT)
    if stated is not None and stated not in MOUNTS:
        raise UsageError(f"--set mount={stated}: expected flange (eye in hand) or base (eye to hand).")
    if stated is not None and known is not None and stated != known:
        raise UsageError(f"--set mount={stated}: {file} states that the camera is mounted on the {known}.")
    if known is None and stated is None:
        raise UsageError(
            f"{file}: is the camera on the flange or fixed in the cell? State it with --set mount=flange (eye in"
            " hand) or --set mount=base (eye to hand)."
        )
    return known or cast("Mount", stated)


def pairs_dataset(pairs: Pairs, mount: Mount, options: ImportOptions, left_out: tuple[str, ...] = ()) -> Imported:
    """The data set of pairs.

    A camera on the flange is a body whose poses are measured in the target; a target on the flange one measured in the
    camera.
    """
    if not len(pairs.poses):
        raise DataError(f"{pairs.file} has no samples.", file=pairs.file)
    body = BODIES[mount]
    T = inverse(pairs.T_camera_target) if mount == "flange" else pairs.T_camera_target
    n = len(pairs.poses)
    dataset = Dataset(
        options.name,
        pairs.poses,
        Points(np.arange(n), (body,) * n, xyz=T[:, :3, 3], columns={"quaternion": to_quaternion(T[:, :3, :3])}),
        kind="pose",
        robot=options.robot if pairs.poses.q is not None else None,
        path_known=options.path_known,
        source=pairs.file,
    )
    if pairs.guess is not None:
        placed = ("tool.camera", pairs.guess) if mount == "flange" else ("base", inverse(pairs.guess))
        dataset = replace(dataset, parameters=placed_camera(placed[1], placed[0]))
    inverted = ", inverted: the camera seen from the target" if mount == "flange" else ""
    numbered = "(number of the sample)"
    read_from = {
        "poses.csv": {"pose": numbered, "": pairs.flange_from},
        "points.csv": {"pose": numbered, "point": f"({MOUNT}={mount})", "": f"{pairs.target_from}{inverted}"},
    }
    return Imported(dataset, read_from, left_out)


def seen_by_tags(dataset: Dataset) -> Dataset:
    """The poses of tags in a camera on the flange, as poses of the camera in each tag: a sensor for each.

    They share the hand-eye parameters `tool.camera.*`; each tag has its own `TAG.base.*`.
    """
    points, tags = dataset.points, tuple(dict.fromkeys(dataset.points.names))
    T = inverse(pose(from_quaternion(points["quaternion"]), points["xyz"]))
    turns = {"quaternion": to_quaternion(T[:, :3, :3])}
    of_camera = replace(points, names=(BODIES["flange"],) * len(points), xyz=T[:, :3, 3], columns=turns)
    if len(tags) == 1:
        return replace(dataset, points=of_camera)
    alone = replace(dataset, poses=Poses(()), points=of_camera.take(slice(0, 0)), robot=None, warnings=())
    tag_of = dict[str, str]()
    for tag in tags:
        name = re.sub(r"[^A-Za-z0-9_-]", "_", tag)
        if (first := tag_of.setdefault(name, tag)) != tag:
            how = "Rename one with other letters a to z, digits, _ or -."
            raise DataError(f"The tags {first!r} and {tag!r} would both be called {name!r}. {how}")
    members = tuple(SensorData(name, alone, f"points_{name}.csv") for name in tag_of)
    return with_points_of(
        replace(dataset, members=members), [of_camera.take(points.number == number) for number in range(len(tags))]
    )


def placed_camera(T: Array, prefix: str) -> dict[str, Parameter]:
    """Nominal values of the six parameters of a motion (4, 4) by another tool, with wide bounds."""
    values = [*T[:3, 3].tolist(), *map(float, to_angles(T[:3, :3]))]
    return {
        f"{prefix}.{part}": Parameter(f"{prefix}.{part}", unit, value, value - SPAN[unit], value + SPAN[unit])
        for (part, unit), value in zip(POSE_UNITS.items(), values, strict=True)
    }
