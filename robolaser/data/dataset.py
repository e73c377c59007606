"""A data set: measured poses and points, and prior knowledge of robot, sensor and target."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.board import Board
from robolaser.data.csv_tables import numbers, rows_of
from robolaser.data.sensor_format import SensorFormat, format_of_several, sensor_format
from robolaser.data.sessions import Sessions
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError, RobotError
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import Robot

COMMAND = "q_command_"  # prefix of a column with the commanded values of a joint


@final
@dataclass(frozen=True)
class Poses:
    """Poses of the arm (n)."""

    names: tuple[str, ...]  # unique texts
    time_s: Array | None = None  # (n,) [s], or only an order; None: unknown
    q: Array | None = None  # joint readings, (n, j) [rad or m]; None where flange poses were measured
    # velocities at the exposure: of the joints, (n, j) [rad/s or m/s], or where flange poses were measured, of the
    # flange in its own frame, (n, 6) [m/s, rad/s]; NaN where the path does not show them
    qd: Array | None = None
    T_base_flange: Array | None = None  # measured flange poses, (n, 4, 4); None where joint angles were read
    image: tuple[str, ...] | None = None  # path of each pose's image in the data set's folder
    payload_kg: Array | None = None  # payload at each pose, (n,) [kg]; None: not stated
    temperature_c: Array | None = None  # temperature at each pose, (n,) [°C]; None: not measured
    session: tuple[str, ...] | None = None  # the campaign that each pose belongs to; None: all to one
    following: Mapping[str, Array] = field(default_factory=dict)  # command less reading, by joint, (n,) [rad or m]
    extra: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # any further column, as texts
    qd_from_path: bool = False  # whether velocities are finite differences along the path, not recorded ones

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def coordinates(self) -> Mapping[str, Array]:
        """Possible coordinates of a gap, (n,) each: payload, temperature, `following`, numbers of `extra`."""
        further = {name: numbers(cells) for name, cells in self.extra.items() if not name.startswith(COMMAND)}
        further |= {f"{COMMAND}{joint} less q_{joint}": values for joint, values in self.following.items()}
        known = {"payload_kg": self.payload_kg, "temperature_c": self.temperature_c, **further}
        return {name: values for name, values in known.items() if values is not None}

    def take(self, rows: Ints) -> "Poses":
        """Only the poses with these numbers."""
        return rows_of(self, rows)


@final
@dataclass(frozen=True)
class Points:
    """Measured points, the rows of points.csv (m).

    A required array is `points["pixel"]`, `points["xyz"]` or `points[name]`.
    """

    pose: Ints = field(default_factory=lambda: np.empty(0, np.int64))  # number of each row's pose, (m,)
    # a stripe's point is unique within its pose only; a tracker's names the reflector, a socket's the socket
    names: tuple[str, ...] = ()
    repeat: Ints | None = None  # number of the shot at an unmoved pose, (m,), or None
    pixel: Array | None = None  # u and v, (m, 2) [px], where the sensor has pixels
    xyz: Array | None = None  # target point (stripe) or measured point (tracker), (m, 3) [m]; None for sockets
    columns: Mapping[str, Array] = field(default_factory=dict)  # further arrays of the sensor's format, (m, k) each
    # number of the sensor that saw each row, (m,), where there are several; its missing arrays are zero there, and
    # names start with the sensor's
    sensor: Ints | None = None

    def __len__(self) -> int:
        return len(self.pose)

    def __contains__(self, name: str) -> bool:
        return name in self.arrays

    def __getitem__(self, name: str) -> Array:
        """An array of the sensor's format by name, (m, k).

        Raises:
            DataError: These points have no such array.
        """
        if name not in self:
            raise DataError(f"points.csv has no {name} of the points, which is needed here.", file="points.csv")
        return self.arrays[name]

    @cached_property
    def arrays(self) -> Mapping[str, Array]:
        """The existing arrays of the sensor's format, by name, (m, k) each."""
        known = {"pixel": self.pixel, "xyz": self.xyz, **self.columns}
        return {name: values for name, values in known.items() if values is not None}

    def with_arrays(self, arrays: Mapping[str, Array]) -> "Points":
        """The same rows with these arrays of the sensor's format, by name, and no others."""
        columns = {name: values for name, values in arrays.items() if name not in ("pixel", "xyz")}
        return replace(self, pixel=arrays.get("pixel"), xyz=arrays.get("xyz"), columns=columns)

    @cached_property
    def number(self) -> Ints:
        """Number of each row's name among the different ones, in order of first occurrence, (m,)."""
        number = {name: i for i, name in enumerate(dict.fromkeys(self.names))}
        return np.fromiter(map(number.__getitem__, self.names), np.int64, len(self))

    @cached_property
    def place(self) -> Ints:
        """Number of each row's point, (m,): the same for its repeats, another for a point of that name elsewhere."""
        _, point = np.unique(self.pose * (self.number.max(initial=0) + 1) + self.number, return_inverse=True)
        return point

    def take(self, rows: Ints | Bools | slice) -> "Points":
        """Only the rows with these numbers."""
        return rows_of(self, np.arange(len(self))[rows])


@final
@dataclass(frozen=True)
class SensorData:
    """A sensor of a data set."""

    name: str  # its name in results; "" where it is the only one
    data: "Dataset"  # its data set: its part of dataset.toml; among `sensors` also all poses, and its points
    file: str = "points.csv"  # its points, as `points.csv`
    camera: str = ""  # name of its camera, which several sensors may share; "" where it is the only sensor
    target: str = ""  # name of its target; likewise
    # size of a unit of its residuals relative to other sensors [m]: typically the size of a pixel on the target
    metres_per_unit: float = 1.0
    rows: Ints = field(default_factory=lambda: np.empty(0, np.int64))  # among `sensors`: its rows among all, (m,)

    @property
    def prefix(self) -> str:
        """Prefix of the names of its sources of noise."""
        return f"{self.name}." if self.name else ""


@final
@dataclass(frozen=True, repr=False)
class Dataset:
    """A data set of the format `robolaser-dataset/1`, checked.

    Attributes:
        kind: Of the sensor: "stripe", "camera", "point", "pose", "socket", "profile", or a further one that is
            registered; of several sensors the first one's, as all attributes of a sensor here.
        options: The sensor's own keys of `[sensor]`, an instance of its format's `options`; None where it has none.
        parameters: Nominal values and bounds as given, by name.
        bracket_quat: Nominal orientation of the camera on the flange, (x, y, z, w).
        angles: Order of the hand-eye angles, "xyz" or "zyz".
        image_px: Width and height of the images [px].
        placed: Whether target points are given in the base frame.
        distances_m: Known distances between named points: (point, point, distance).
        radius_m: Radius of each ball that profiles show, by name [m].
        time_is_order: Whether `time_s` only orders the poses.
        path_known: Whether the arm moved straight from each pose to the next.
        sessions: The campaigns, where poses.csv has a column `session`; None: there is one.
        members: Each of several sensors, by dataset.toml; `sensors` are all, also where there is one.
        warnings: Warnings of the data set.
        whole: The complete data set, where this is a part of it or its means; quantities of a run refer to it.

    Examples:
        >>> dataset
        <Dataset paper: laser stripe scanner, robot scorbot_er7, 25 points in 5 poses>
        >>> dataset.poses.q.shape
        (5, 5)
    """

    name: str
    poses: Poses
    points: Points = field(default_factory=Points)
    kind: str = "stripe"
    robot: Robot | None = None
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    options: Any = None
    stripe_axis: str = "u"
    bracket_quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
    angles: str = "xyz"
    image_px: tuple[int, int] | None = None
    board: Board | None = None
    placed: bool = True
    distances_m: tuple[tuple[str, str, float], ...] = ()
    radius_m: Mapping[str, float] = field(default_factory=dict)
    noise: Noise = field(default_factory=Noise)
    time_is_order: bool = False
    path_known: bool = True
    sessions: Sessions | None = None
    members: tuple[SensorData, ...] = ()
    source: str = ""
    licence: str = ""
    folder: Path | None = None
    warnings: tuple[str, ...] = ()
    whole: "Dataset | None" = field(default=None, compare=False)

    @classmethod
    def from_frames(
        cls,
        poses: Mapping[str, Iterable[Any]],
        points: Mapping[str, Iterable[Any]],
        *,
        robot: Robot | str | Path | None = None,
        flange: str | None = None,
        sensor: str = "point",
        name: str = "measured",
        **tables: Mapping[str, Any],
    ) -> "Dataset":
        """A data set of columns in memory, such as a dictionary of lists or a data frame of pandas, checked like files.

        Args:
            poses: The columns of poses.csv; without `pose`, poses are called 0, 1, 2 …
            points: The columns of points.csv.
            robot: The arm: what `find_robot` takes, or its result; None for measured flange poses.
            flange: Frame of a robot's file that carries the sensor.
            sensor: Its kind.
            name: Name of the data set.
            tables: Of dataset.toml, such as `noise={"point_m": 3e-5}` or `target={"placed": False}`.

        Raises:
            DataError: A column is missing or has a wrong value, as in a file; columns have different lengths.
            UsageError: There is no such robot, or the flange is of none that is read here.

        Examples:
            >>> poses = {f"q_{joint}": [0.1, 0.4, 0.9] for joint in robolaser.find_robot("ur5").joints}
            >>> points = {"pose": [0, 1, 2], "point": "AAA", "x_m": [1, 2, 3], "y_m": [0, 1, 0], "z_m": [1, 1, 2]}
            >>> robolaser.Dataset.from_frames(poses, points, robot="ur5", noise={"point_m": 3e-5})
            <Dataset measured: laser tracker, robot ur5, 3 points in 3 poses>
        """
        frames = import_module("robolaser.data.frames")  # it imports this file
        described = {"": {"format": "robolaser-dataset/1", "name": name}, "sensor": {"kind": sensor}, **tables}
        made: Dataset = frames.dataset_of_frames(poses, points, robot, flange, described)
        return made

    @property
    def summary(self) -> str:
        """Sensor, arm, and number of points and poses."""
        arm = f"robot {self.robot.name}" if self.robot else "measured flange poses"
        counts = (("point", len(self.points)), ("pose", len(set(self.points.pose.tolist()))))
        points, poses = (f"{count} {what}{'s' * (count != 1)}" for what, count in counts)
        return f"{self.format.title}, {arm}, {points} in {poses}"

    def __repr__(self) -> str:
        """Its name and summary."""
        return f"<Dataset {self.name}: {self.summary}>"

    @property
    def format(self) -> SensorFormat:
        """The format of its kind of sensor; of several sensors, that of all of them together."""
        if not self.members:
            return sensor_format(self.kind)
        return format_of_several([member.data.format for member in self.members])

    @property
    def sensors(self) -> tuple[SensorData, ...]:
        """All sensors, with their points."""
        return self._several or (SensorData("", self, rows=np.arange(len(self.points))),)

    @cached_property
    def _several(self) -> tuple[SensorData, ...]:
        seen = [np.flatnonzero(self.sensor_of_row == number) for number in range(len(self.members))]
        return tuple(
            replace(one, data=self._seen_by(one, rows), rows=rows) for one, rows in zip(self.members, seen, strict=True)
        )

    @property
    def sensor_of_row(self) -> Ints:
        """Number of the sensor that saw each row, (m,)."""
        of_row = self.points.sensor
        return np.zeros(len(self.points), dtype=np.int64) if of_row is None else of_row

    def _seen_by(self, member: SensorData, rows: Ints) -> "Dataset":
        data, points = member.data, self.points.take(rows)
        names = tuple(name.removeprefix(f"{member.name}/") for name in points.names)
        repeat = None if points.repeat is None or not points.repeat.any() else points.repeat
        arrays = {name: values for name, values in points.arrays.items() if name in data.format.columns}
        own = Points(points.pose, names, repeat).with_arrays(arrays)
        return replace(
            data,
            name=self.name,
            poses=self.poses,
            points=own,
            robot=self.robot,
            sessions=self.sessions,
            folder=self.folder,
        )

    @property
    def session_of_pose(self) -> Ints:
        """Number of each pose's session, (n,); all 0 where there is one."""
        if self.sessions is None or self.poses.session is None:
            return np.zeros(len(self.poses), dtype=np.int64)
        number = {name: i for i, name in enumerate(self.sessions.names)}
        return np.fromiter(map(number.__getitem__, self.poses.session), np.int64, len(self.poses))

    @property
    def paths(self) -> tuple[Ints, ...]:
        """Numbers of the poses in order of time, by session, (k,) each.

        In the order of the list where times are unknown.
        """
        session, time_s = self.session_of_pose, self.poses.time_s
        order = np.arange(len(session)) if time_s is None else np.argsort(time_s, kind="stable").astype(np.int64)
        return tuple(order[session[order] == number] for number in np.unique(session))

    @property
    def arm(self) -> tuple[Robot, Array]:
        """The arm and its joint readings, (n, j) [rad or m].

        Raises:
            RobotError: Flange poses were measured instead.
        """
        if self.robot is None or self.poses.q is None:
            raise RobotError(f"{self.name} has measured flange poses and no joint angles, which are needed here.")
        return self.robot, self.poses.q

    def flange(self) -> Array:
        """T_base_flange at every pose, as measured or by the nominal kinematics, (n, 4, 4).

        Raises:
            RobotError: There are neither joint angles nor flange poses.
        """
        if self.robot is None and self.poses.T_base_flange is not None:
            return self.poses.T_base_flange
        robot, q = self.arm
        return robot.forward(q)

    def in_whole(self) -> Ints | None:
        """Numbers of the poses among those of `whole`, (n,); None without it, and where it lacks one."""
        names = () if self.whole is None else self.whole.poses.names
        number = {name: i for i, name in enumerate(names)}
        if not all(name in number for name in self.poses.names):
            return None
        return np.array([number[name] for name in self.poses.names], dtype=np.int64)

    def of_poses(self, chosen: Bools) -> "Dataset":
        """The data set with only the chosen poses (n,) and their points."""
        number = np.cumsum(chosen) - 1
        points = self.points.take(chosen[self.points.pose])
        return replace(
            self, poses=self.poses.take(np.flatnonzero(chosen)), points=replace(points, pose=number[points.pose])
        )
