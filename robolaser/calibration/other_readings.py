"""Other ways to read a data set: what the files of people who measured well have wrong."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final, Literal, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.exchanged_points import exchanged_points, fault_text, with_names
from robolaser.data.dataset import Dataset
from robolaser.errors import RobolaserError
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.sensors.mounting import Mounting
from robolaser.robot.by_name import find_robot, known_robots

FAR_OUTSIDE = 1.0  # how far a joint may stand outside its limits under a hypothesis [rad or m], as in `poses.csv`
FEWEST_POSES = 6  # of which rows may be one pose off
DEGREE = np.pi / 180.0
LENGTHS: Final = {
    "in inches": 0.0254,
    "in feet": 0.3048,
    "in centimetres": 0.01,
    "in millimetres": 1e-3,
    "divided by 1000 twice": 1e3,
}
"""What lengths may be instead of metres, and the metres of one."""


@final
@dataclass(frozen=True)
class Hypothesis:
    """A data set read otherwise.

    Attributes:
        dataset: Read so.
        fault: What is then wrong with the files: the beginning of a sentence.
        where: What is to be corrected.
        shift: By how many poses the rows of points.csv are off.
    """

    dataset: Dataset
    fault: str
    where: str = "poses.csv, or the file that it was made from"
    shift: int = 0


@final
@dataclass(frozen=True)
class Misreading:
    """Another way to read the joints of `poses.csv`."""

    columns: tuple[int, ...]  # which column each joint's reading is from, (j,)
    factors: tuple[float, ...]  # what it is multiplied by, (j,)
    fault: str  # what is then wrong with the file: the beginning of a sentence

    def of(self, values: Array) -> Array:
        """Readings or velocities (n, j) as they are meant."""
        meant: Array = values[:, list(self.columns)] * np.array(self.factors)
        return meant


def read_otherwise(dataset: Dataset) -> Iterator[Hypothesis]:
    """All that may be wrong with files whose points are centimetres off.

    Points of some poses exchanged; rows one pose off, flange poses the other way round, the sensor at the other end;
    lengths in other units, a left-handed frame, transposed rotations; joints exchanged, reversed or in degrees.
    """
    if names := exchanged_points(dataset):
        yield Hypothesis(with_names(dataset, names), fault_text(names, dataset.poses.names), "points.csv")
    yield from _of_rows_and_ends(dataset)
    yield from _of_lengths(dataset)
    if dataset.robot is not None and dataset.poses.q is not None:
        yield from (Hypothesis(_read_as(dataset, reading), reading.fault) for reading in _readings(dataset))


def other_arms(dataset: Dataset) -> Iterator[Hypothesis]:
    """Known arms whose joints have the names of this one's: another size or generation of it."""
    robot = dataset.robot
    if robot is None or dataset.poses.q is None:
        return
    for entry in known_robots():
        if entry.joints != robot.joints:
            continue
        try:
            other = find_robot(entry.name, gravity=robot.gravity)
        except RobolaserError:  # its package is not installed
            continue
        fault = f"The arm seems to be a {entry.title}, and not the {robot.name} of dataset.toml"
        yield Hypothesis(replace(dataset, robot=other), fault, "urdf under [robot] in dataset.toml")


def _of_rows_and_ends(dataset: Dataset) -> Iterator[Hypothesis]:
    points, count = dataset.points, len(dataset.poses)
    for shift, which in ((1, "after"), (-1, "before")):
        pose = points.pose + shift
        kept = np.flatnonzero((pose >= 0) & (pose < count))
        if len(kept) and count > FEWEST_POSES:
            moved = replace(points.take(kept), pose=pose[kept])
            fault = f"The points, or images, seem to belong to the pose {which} theirs"
            yield Hypothesis(replace(dataset, points=moved), fault, "the rows of poses.csv or points.csv", shift)
    T, options = dataset.poses.T_base_flange, dataset.options
    end: Literal["flange", "base"] = "flange" if getattr(options, "mount", "flange") == "base" else "base"
    if T is not None:  # a sensor at the other end sees the same with inverse poses
        inverted = replace(dataset, poses=replace(dataset.poses, T_base_flange=inverse(T)))
        mounted = f", or the sensor is mounted on the {end}" if isinstance(options, Mounting) else ""
        yield Hypothesis(inverted, f"poses.csv seems to hold T_flange_base, the inverse of T_base_flange{mounted}")
    elif isinstance(options, Mounting):
        swapped = replace(dataset, options=replace(options, mount=end), parameters={}, placed=False)
        fault = f"The sensor seems to be mounted on the {end}"
        yield Hypothesis(swapped, fault, "mount under [sensor] in dataset.toml")


def _of_lengths(dataset: Dataset) -> Iterator[Hypothesis]:
    """Lengths in other units, mirrored axes, rotations that are transposed."""
    points, T = dataset.points, dataset.poses.T_base_flange
    file = "points.csv, or the file that it was made from"
    if points.xyz is not None and points.pixel is None:
        for unit, factor in LENGTHS.items():
            scaled = replace(points, xyz=points.xyz * factor)
            yield Hypothesis(replace(dataset, points=scaled), f"The points seem to be {unit}", file)
        mirrored = replace(points, xyz=points.xyz * (1.0, -1.0, 1.0))
        yield Hypothesis(
            replace(dataset, points=mirrored), "The points seem to be in a left-handed frame, one axis mirrored", file
        )
    if T is None:
        return
    for unit, factor in LENGTHS.items():
        yield Hypothesis(_with_flange(dataset, T, scale=factor), f"The places of the flange seem to be {unit}")
    for axis in range(3) if dataset.placed else (1,):  # about a target that has no place, mirrored axes are alike
        fault = "The flange poses seem to be in a left-handed frame, one axis mirrored"
        yield Hypothesis(_with_flange(dataset, T, mirrored=axis), fault)
    transposed = _with_flange(dataset, T, transpose=True)
    yield Hypothesis(transposed, "The rotations of the flange poses seem to be transposed")


def _with_flange(
    dataset: Dataset, T: Array, *, scale: float = 1.0, mirrored: int | None = None, transpose: bool = False
) -> Dataset:
    read = T.copy()
    read[:, :3, 3] *= scale
    if mirrored is not None:
        side = np.where(np.arange(3) == mirrored, -1.0, 1.0)
        read[:, :3, :3] *= side[:, None] * side
        read[:, :3, 3] *= side
    if transpose:
        read[:, :3, :3] = np.swapaxes(T[:, :3, :3], 1, 2)
    return replace(dataset, poses=replace(dataset.poses, T_base_flange=read))


def _readings(dataset: Dataset) -> Iterator[Misreading]:
    """Hypotheses under which all joints stay near their limits."""
    robot, q = dataset.arm
    j, moves = len(robot.joints), np.ptp(q, axis=0) > 0
    whole, ones = tuple(range(j)), (1.0,) * j
    turning = np.flatnonzero(moves & ~robot.prismatic)
    for reading in (
        *_exchanged(robot.joints, robot.prismatic, moves),
        *(
            Misreading(whole, _but(ones, i, -1.0), f"q_{robot.joints[i]} seems to have the wrong sign")
            for i in np.flatnonzero(moves).tolist()
        ),
        *(
            Misreading(whole, _but(ones, i, DEGREE), f"q_{robot.joints[i]} seems to be in degrees")
            for i in turning.tolist()
        ),
        *_all_scaled(turning, ones, whole),
    ):
        meant = reading.of(q)
        if ((meant > robot.lower - FAR_OUTSIDE) & (meant < robot.upper + FAR_OUTSIDE)).all():
            yield reading


def _exchanged(joints: tuple[str, ...], prismatic: Bools, moves: Bools) -> Iterator[Misreading]:
    for a, b in combinations(range(len(joints)), 2):
        if prismatic[a] == prismatic[b] and (moves[a] or moves[b]):
            columns = list(range(len(joints)))
            columns[a], columns[b] = b, a
            fault = f"The columns q_{joints[a]} and q_{joints[b]} of poses.csv seem to be exchanged"
            yield Misreading(tuple(columns), (1.0,) * len(joints), fault)


def _all_scaled(turning: Ints, ones: tuple[float, ...], whole: tuple[int, ...]) -> Iterator[Misreading]:
    for factor, fault in (
        (DEGREE, "All angles of poses.csv seem to be in degrees"),
        (1 / DEGREE, "All angles of poses.csv seem to be divided by 57.3, as if they had been in degrees"),
    ):
        yield Misreading(whole, tuple(factor if i in turning else one for i, one in enumerate(ones)), fault)


def _but(ones: tuple[float, ...], i: int, factor: float) -> tuple[float, ...]:
    return (*ones[:i], factor, *ones[i + 1 :])


def _read_as(dataset: Dataset, reading: Misreading) -> Dataset:
    poses = dataset.poses
    assert poses.q is not None
    qd = None if poses.qd is None else reading.of(poses.qd)
    return replace(dataset, poses=replace(poses, q=reading.of(poses.q), qd=qd))
