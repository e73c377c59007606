"""Other ways to read a data set: common faults in the files of good measurements."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import Mount
from robolaser.errors import RobolaserError
from robolaser.geometry.rigid_motion import inverse, pose
from robolaser.model.sensors.in_cell import Mounting
from robolaser.robot.by_name import find_robot, known_robots
from robolaser.robot.kinematics import Robot

FAR_OUTSIDE = 1.0  # how far a joint may be outside its limits under a hypothesis [rad or m], as in `poses.csv`
FEWEST_POSES = 6  # of which rows may be one pose off
DEGREE = np.pi / 180.0
LENGTHS: Final = {
    "in inches": 0.0254,
    "in feet": 0.3048,
    "in centimetres": 0.01,
    "in millimetres": 1e-3,
    "divided by 1000 twice": 1e3,
    "in inches, read as millimetres": 25.4,
    "in millimetres, read as inches": 1.0 / 25.4,
    "in centimetres, read as millimetres": 10.0,
    "in millimetres, read as centimetres": 0.1,
}
"""Units that lengths may have instead of metres or of the unit they were converted from, each in metres."""
MIRRORED: Final = "mirrored"
IMAGES: Final = "mirrored images"
MOST_NAMES: Final = 6  # names of points of which all orders are tried
MOST_LISTED: Final = 4  # poses that a sentence names
SHIFTS: Final = {1: "after", -1: "before"}
ROWS: Final = "the rows of poses.csv or points.csv"
FAR_APART: Final = 10.0  # times the usual deviation above which a pose's distances differ, and below which they fit
LEAST_M: Final = 2e-4
"""The same at least. A judgement: distances on a tool differ by millimetres, the errors of trackers are smaller."""


@final
@dataclass(frozen=True)
class Hypothesis:
    """A data set read otherwise."""

    dataset: Dataset  # read so
    fault: str  # what is then wrong with the files: the beginning of a sentence
    where: str = "poses.csv, or the file that it was made from"  # what is to be corrected
    shift: int = 0  # by how many poses the rows of points.csv are off
    # shared with hypotheses that no data can distinguish from it, as points in inches and flange poses in an inch
    # of metres have; "": nothing
    alike: str = ""
    scale: float = 1.0  # of the measured points, by which all errors shrink, also without reason


def read_otherwise(dataset: Dataset) -> Iterator[Hypothesis]:
    """All hypotheses for files whose points are centimetres off.

    Points of some poses exchanged; rows one pose off, a target elsewhere, flange poses inverted, the sensor at the
    other end; lengths in other units, a left-handed frame, transposed rotations; images mirrored, with their axes
    exchanged, or with another axis of the stripe; another flange; joints exchanged, reversed, in degrees, or late.
    """
    if names := exchanged_points(dataset):
        yield Hypothesis(with_names(dataset, names), fault_text(names, dataset.poses.names), "points.csv")
    yield from _of_rows_and_ends(dataset)
    yield from _of_lengths(dataset)
    yield from _of_images(dataset)
    if dataset.robot is not None and dataset.poses.q is not None:
        yield from _of_flange(dataset, dataset.robot)
        yield from _of_joints(dataset)


def other_arms(dataset: Dataset) -> Iterator[Hypothesis]:
    """Known arms with the same joint names: another size or generation."""
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
        if np.allclose(other.placements, robot.placements):
            continue
        fault = f"The arm seems to be a {entry.title}, and not the {robot.name} of dataset.toml"
        yield Hypothesis(replace(dataset, robot=other), fault, "urdf under [robot] in dataset.toml")


def _of_rows_and_ends(dataset: Dataset) -> Iterator[Hypothesis]:
    for shift, which in SHIFTS.items():
        moved = with_rows_moved(dataset, shift)
        if len(moved.points) and len(dataset.poses) > FEWEST_POSES:
            fault = f"The points, or images, seem to belong to the pose {which} theirs"
            yield Hypothesis(moved, fault, ROWS, shift)
            for sensor in dataset.sensors if dataset.members else ():
                alone = with_rows_moved(dataset, shift, of=sensor.rows)
                fault = f"All rows of {sensor.file} seem to belong to the pose {which} theirs"
                yield Hypothesis(alone, fault, sensor.file, shift)
    if dataset.placed and dataset.points.pixel is not None:
        fault = "The points of the target seem to be in a frame of its own, and not in the base frame"
        where = "placed under [target] in dataset.toml"
        yield Hypothesis(replace(dataset, placed=False), fault, where, alike=MIRRORED)  # as if a flat target is turned
    T, options = dataset.poses.T_base_flange, dataset.options
    end: Mount = "flange" if getattr(options, "mount", "flange") == "base" else "base"
    if T is not None:  # a sensor at the other end sees the same with inverse poses
        inverted = replace(dataset, poses=replace(dataset.poses, T_base_flange=inverse(T)))
        mounted = f", or the sensor is mounted on the {end}" if isinstance(options, Mounting) else ""
        yield Hypothesis(inverted, f"poses.csv seems to hold T_flange_base, the inverse of T_base_flange{mounted}")
    elif isinstance(options, Mounting):
        swapped = replace(dataset, options=replace(options, mount=end), parameters={}, placed=False)
        fault = f"The sensor seems to be mounted on the {end}"
        yield Hypothesis(swapped, fault, "mount under [sensor] in dataset.toml")


def with_rows_moved(
    dataset: Dataset, shift: int, first: int = 0, last: int | None = None, *, of: Ints | None = None
) -> Dataset:
    """Rows from a first to a last pose, or to the end, moved by so many poses, without rows that leave their session.

    Only rows with the numbers `of` move; None: all.
    """
    points, session = dataset.points, dataset.session_of_pose
    moves = (points.pose >= first) & (points.pose <= (len(session) if last is None else last))
    if of is not None:
        moves &= np.isin(np.arange(len(points)), of)
    pose = points.pose + shift * moves
    there = np.clip(pose, 0, len(session) - 1)
    kept = np.flatnonzero((pose == there) & (session[there] == session[points.pose]))
    return replace(dataset, points=replace(points.take(kept), pose=pose[kept]))


def _of_lengths(dataset: Dataset) -> Iterator[Hypothesis]:
    """Lengths in other units, mirrored axes, transposed rotations."""
    points, T = dataset.points, dataset.poses.T_base_flange
    if points.xyz is not None:
        is_target = points.pixel is not None
        what = "points of the target" if is_target else "points"
        file = "points.csv, or " + ("the size of the target" if is_target else "the file that it was made from")
        for unit, factor in LENGTHS.items():
            scaled = replace(points, xyz=points.xyz * factor)
            fault = f"The {what} seem to be {unit}"
            yield Hypothesis(replace(dataset, points=scaled), fault, file, alike=f"{factor:.6g}", scale=factor)
        fault = f"The {what} seem to be in a left-handed frame, one axis mirrored"
        for side in _mirrors(dataset):
            mirrored = replace(points, xyz=points.xyz * side)
            yield Hypothesis(replace(dataset, points=mirrored), fault, file, alike=MIRRORED)
    for unit, factor in LENGTHS.items() if dataset.distances_m else ():
        known = tuple((one, other, factor * distance) for one, other, distance in dataset.distances_m)
        where = "distances_m under [target] in dataset.toml"
        yield Hypothesis(replace(dataset, distances_m=known), f"The known distances seem to be {unit}", where)
    if T is None:
        return
    turned, placed = T[:, :3, :3], T[:, :3, 3]
    for unit, factor in LENGTHS.items():
        fault = f"The positions of the flange seem to be {unit}"
        yield Hypothesis(_with_flange(dataset, turned, placed * factor), fault, alike=f"{1.0 / factor:.6g}")
    for side in _mirrors(dataset):
        fault = "The flange poses seem to be in a left-handed frame, one axis mirrored"
        yield Hypothesis(_with_flange(dataset, turned * side[:, None] * side, placed * side), fault, alike=MIRRORED)
    transposed = _with_flange(dataset, np.swapaxes(turned, 1, 2), placed)
    yield Hypothesis(transposed, "The rotations of the flange poses seem to be transposed")


def _of_images(dataset: Dataset) -> Iterator[Hypothesis]:
    """Mirrored images, exchanged columns, which a camera may see as the same, and the other axis of a stripe."""
    points, pixel = dataset.points, dataset.points.pixel
    if pixel is None or dataset.members:
        return
    exchanged = replace(dataset, points=replace(points, pixel=pixel[:, ::-1].copy()))
    fault = "The columns u_px and v_px of points.csv seem to be exchanged"
    yield Hypothesis(exchanged, fault, "points.csv, or the file that it was made from", alike=IMAGES)
    for axis, size in enumerate(dataset.image_px or ()):
        mirrored = pixel.copy()
        mirrored[:, axis] = size - 1.0 - pixel[:, axis]
        reading = replace(dataset, points=replace(points, pixel=mirrored))
        yield Hypothesis(reading, "The images seem to be mirrored", "the images, or points.csv", alike=IMAGES)
    if "scanner" in dataset.format.tables:
        other = "v" if dataset.stripe_axis == "u" else "u"
        fault = f'stripe_axis seems to be "{other}", and not "{dataset.stripe_axis}"'
        yield Hypothesis(replace(dataset, stripe_axis=other), fault, "stripe_axis under [sensor] in dataset.toml")


def _mirrors(dataset: Dataset) -> Array:
    """Factors of the axes, (., 3), one of them mirrored: with an unplaced target, all mirrored axes are equivalent."""
    return (1.0 - 2.0 * np.eye(3))[slice(None) if dataset.placed else slice(1, 2)]


def _with_flange(dataset: Dataset, turned: Array, placed: Array) -> Dataset:
    return replace(dataset, poses=replace(dataset.poses, T_base_flange=pose(turned, placed)))


def _of_flange(dataset: Dataset, robot: Robot) -> Iterator[Hypothesis]:
    """Links that further joints move as the flange: what fewer joints move may fit for standing still."""
    for link in robot.by_pinocchio.links:
        if link.joint is None:
            continue
        other = Robot.from_urdf(robot.urdf, flange=link.name, joints=robot.joints, gravity=robot.gravity)
        if {*robot.chain} < {*other.chain}:
            fault = f"What is on the flange seems to be on {link.name}, and not on {robot.flange}"
            yield Hypothesis(replace(dataset, robot=other), fault, "flange under [robot] in dataset.toml")


def _of_joints(dataset: Dataset) -> Iterator[Hypothesis]:
    """Other readings of joints that keep all of them near their limits."""
    (robot, q), poses = dataset.arm, dataset.poses
    moves = np.ptp(q, axis=0) > 0
    for columns, factors, fault in _joints_read_otherwise(robot, moves):
        meant = q[:, columns] * factors
        if ((meant > robot.lower - FAR_OUTSIDE) & (meant < robot.upper + FAR_OUTSIDE)).all():
            qd = None if poses.qd is None else poses.qd[:, columns] * factors
            yield Hypothesis(replace(dataset, poses=replace(poses, q=meant, qd=qd)), fault)
    for i in np.flatnonzero(moves) if moves.sum() > 1 else ():  # the only one that moves is late with all rows
        for shift, which in SHIFTS.items():
            meant = q.copy()
            meant[:, i] = np.roll(q[:, i], shift)
            kept = np.flatnonzero(dataset.points.pose != (0 if shift > 0 else len(q) - 1))
            moved = replace(dataset, poses=replace(poses, q=meant), points=dataset.points.take(kept))
            yield Hypothesis(moved, f"The readings of q_{robot.joints[i]} seem to belong to the pose {which} theirs")


def _joints_read_otherwise(robot: Robot, moves: Bools) -> Iterator[tuple[Ints, Array, str]]:
    """The column of each joint's reading and its factor, (j,) each, and the fault of the file."""
    joints, every = robot.joints, np.arange(len(robot.joints))
    whole, turning = np.ones(len(joints)), moves & ~robot.prismatic
    for a, b in combinations(every, 2):
        if robot.prismatic[a] == robot.prismatic[b] and (moves[a] or moves[b]):
            exchanged = np.where(every == a, b, np.where(every == b, a, every))
            fault = f"The columns q_{joints[a]} and q_{joints[b]} of poses.csv seem to be exchanged"
            yield exchanged, whole, fault
    for i in np.flatnonzero(moves):
        yield every, np.where(every == i, -1.0, 1.0), f"q_{joints[i]} seems to have the wrong sign"
    for i in np.flatnonzero(turning):
        yield every, np.where(every == i, DEGREE, 1.0), f"q_{joints[i]} seems to be in degrees"
    yield every, np.where(turning, DEGREE, 1.0), "All angles of poses.csv seem to be in degrees"
    divided = "All angles of poses.csv seem to be divided by 57.3, as if they had been in degrees"
    yield every, np.where(turning, 1 / DEGREE, 1.0), divided


def exchanged_points(dataset: Dataset) -> Mapping[int, Mapping[str, str]]:
    """The right names of exchanged points by their present names, at some poses: a rigid body keeps its distances.

    Only for tracker points, and where distances differ.
    """
    points = dataset.points
    names = list(dict.fromkeys(points.names))
    if points.xyz is None or points.pixel is not None or not 2 < len(names) <= MOST_NAMES or points.columns:
        return {}
    cells = points.pose * len(names) + points.number
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
    enough = max(FAR_APART * float(np.median(off[whole])), LEAST_M)
    # least difference of two distances of the body: where some are equal, an exchange changes nothing
    if enough > float(np.diff(np.sort(usual[np.triu_indices(len(usual), 1)])).min()):
        return {}
    orders = [list(order) for order in permutations(range(len(names)))]
    found: dict[int, Mapping[str, str]] = {}
    for at in np.flatnonzero(whole & (off > enough)).tolist():
        misfits = [np.abs(apart[at][np.ix_(order, order)] - usual).max() for order in orders]
        if min(misfits) <= enough:
            order = orders[int(np.argmin(misfits))]
            found[at] = {names[was]: names[i] for i, was in enumerate(order) if was != i}
    return found


def with_names(dataset: Dataset, names: Mapping[int, Mapping[str, str]]) -> Dataset:
    """The data set with other point names at some poses."""
    points = dataset.points
    called = zip(points.pose.tolist(), points.names, strict=True)
    right = tuple(names.get(at, {}).get(name, name) for at, name in called)
    return replace(dataset, points=replace(points, names=right))


def fault_text(names: Mapping[int, Mapping[str, str]], poses: Sequence[str]) -> str:
    """The beginning of a sentence: which points of which poses."""
    which = ", ".join(sorted({name for one in names.values() for name in one}))
    where = [poses[number] for number in names]
    listed = ", ".join(where[:MOST_LISTED]) + (" and others" if len(where) > MOST_LISTED else "")
    return f"The points {which} of pose{'s' if len(where) > 1 else ''} {listed} seem to be exchanged"
