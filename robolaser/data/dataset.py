"""What was measured in a cell: poses, points and what is known of robot, sensor and target beforehand."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.geometry.kinematics import Robot
from robolaser.parameters import Parameter


@final
@dataclass(frozen=True)
class Poses:
    """Where the arm stood, one entry a pose (n).

    Attributes:
        names: Unique texts.
        time_s: (n,) [s], or only an order; None: unknown.
        q: Joint angles as read, (n, j) [rad or m]; None where flange poses were measured.
        qd: Joint velocities at the exposure, (n, j) [rad/s or m/s].
        T_base_flange: Measured flange poses, (n, 4, 4); None where joint angles were read.
        image: Path of each pose's image in the data set's folder.
        extra: Any further column, as texts; `temperature_c` and `payload_kg` among them.
    """

    names: tuple[str, ...]
    time_s: Array | None = None
    q: Array | None = None
    qd: Array | None = None
    T_base_flange: Array | None = None
    image: tuple[str, ...] | None = None
    extra: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.names)

    def take(self, rows: Ints) -> "Poses":
        """Only the poses with these numbers."""

        def some(values: Array | None) -> Array | None:
            return None if values is None else values[rows]

        return Poses(
            names=tuple(self.names[i] for i in rows),
            time_s=some(self.time_s),
            q=some(self.q),
            qd=some(self.qd),
            T_base_flange=some(self.T_base_flange),
            image=None if self.image is None else tuple(self.image[i] for i in rows),
            extra={name: tuple(cells[i] for i in rows) for name, cells in self.extra.items()},
        )


@final
@dataclass(frozen=True)
class Points:
    """What was seen, one entry a row of points.csv (m).

    Attributes:
        pose: Number of the pose each row was taken in, (m,).
        names: A stripe's point is unique within its pose only; a tracker's names the reflector, a socket's the socket.
        repeat: Number of the shot at an unmoved pose, (m,), or None.
        pixel: u and v, (m, 2) [px]; stripe only.
        xyz: Target point (stripe) or measured point (tracker), (m, 3) [m]; None for sockets.
    """

    pose: Ints
    names: tuple[str, ...]
    repeat: Ints | None = None
    pixel: Array | None = None
    xyz: Array | None = None

    def __len__(self) -> int:
        return len(self.pose)

    @cached_property
    def number(self) -> Ints:
        """Number of each row's name among the different ones, in the order in which they first come, (m,)."""
        number = {name: i for i, name in enumerate(dict.fromkeys(self.names))}
        return np.fromiter(map(number.__getitem__, self.names), np.int64, len(self))

    @cached_property
    def place(self) -> Ints:
        """Number of each row's point, (m,): the same for its repeats, another for a point of that name elsewhere."""
        _, place = np.unique(self.pose * (self.number.max(initial=0) + 1) + self.number, return_inverse=True)
        return place

    def take(self, rows: Ints | Bools | slice) -> "Points":
        """Only the rows with these numbers."""
        chosen = np.arange(len(self))[rows].tolist()
        return Points(
            pose=self.pose[rows],
            names=tuple(map(self.names.__getitem__, chosen)),
            repeat=None if self.repeat is None else self.repeat[rows],
            pixel=None if self.pixel is None else self.pixel[rows],
            xyz=None if self.xyz is None else self.xyz[rows],
        )


@final
@dataclass(frozen=True)
class Board:
    """A checkerboard: inner corners along x and y, and the side of a square [m]."""

    columns: int
    rows: int
    square_m: float


@final
@dataclass(frozen=True)
class Noise:
    """Known standard deviations per axis; None: to be estimated."""

    pixel_px: float | None = None
    target_m: float | None = None
    joint_rad: float | None = None
    point_m: float | None = None


@final
@dataclass(frozen=True)
class Dataset:
    """A data set of the format `robolaser-dataset/1`, checked.

    Attributes:
        kind: "stripe", "point" or "socket".
        parameters: The sim: nominal values and bounds as given, by name.
        bracket_quat: Nominal turn of the camera on the flange, (x, y, z, w).
        angles: Order of the hand-eye angles, "xyz" or "zyz".
        image_px: Width and height of the images [px].
        placed: Whether target points are given in the base frame.
        distances_m: Known distances between sockets: (socket, socket, distance).
        time_is_order: Whether `time_s` only orders the poses.
        path_known: Whether the robot went straight from each pose to the next.
        warnings: What is odd, but no error.
    """

    name: str
    poses: Poses
    points: Points
    kind: str = "stripe"
    robot: Robot | None = None
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    stripe_axis: str = "u"
    bracket_quat: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    angles: str = "xyz"
    image_px: tuple[int, int] | None = None
    board: Board | None = None
    placed: bool = True
    distances_m: tuple[tuple[str, str, float], ...] = ()
    noise: Noise = field(default_factory=Noise)
    time_is_order: bool = False
    path_known: bool = True
    source: str = ""
    licence: str = ""
    folder: Path | None = None
    warnings: tuple[str, ...] = ()

    def flange(self) -> Array:
        """T_base_flange at every pose, as measured or by the nominal kinematics, (n, 4, 4)."""
        if self.robot is None:
            assert self.poses.T_base_flange is not None  # the folder's reader sees to both
            return self.poses.T_base_flange
        assert self.poses.q is not None
        T: Array = self.robot.forward(self.poses.q[None])[0]
        return T

    def of_poses(self, chosen: Bools) -> "Dataset":
        """The same data set with only the chosen poses (n,) and their points."""
        number = np.cumsum(chosen) - 1
        points = self.points.take(chosen[self.points.pose])
        return replace(
            self,
            poses=self.poses.take(np.flatnonzero(chosen)),
            points=replace(points, pose=number[points.pose]),
        )

    def thinned(self, most: int) -> "Dataset":
        """The same data set with at most about `most` points, evenly taken along each pose's rows."""
        points = self.points
        share = max(3, most // max(1, len(np.unique(points.pose))))
        table = some_of_each(points.pose, share)
        rows = np.sort(table[table >= 0])
        return self if len(rows) == len(points) else replace(self, points=points.take(rows))


def some_of_each(group: Ints, most: int) -> Ints:
    """At most so many rows of each group (m,), evenly taken along them, (groups, most); -1 where it has fewer."""
    order = np.argsort(group, kind="stable")
    counts = np.bincount(group)
    starts = (np.cumsum(counts) - counts)[counts > 0, None]
    counts = counts[counts > 0, None]
    most = min(most, int(counts.max(initial=0)))
    taken, place = np.minimum(most, counts), np.arange(most)
    last = (place > 0) & (place == taken - 1)
    along = np.where(last, counts - 1, place * ((counts - 1) / np.maximum(taken - 1, 1)))
    rows = order[np.minimum(starts + along.round().astype(np.int64), len(order) - 1)]
    return np.where(place < taken, rows, -1)
