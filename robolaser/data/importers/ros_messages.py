"""A ROS bag's messages, as numbers: joint states, transforms, poses and images."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.importers.time_matching import match
from robolaser.data.importers.yaml_file import motion_of_seven
from robolaser.errors import DataError, RobolaserError, UsageError, near
from robolaser.geometry.rigid_motion import inverse
from robolaser.plugins import extra

JOINTS, TF = "sensor_msgs/msg/JointState", ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
POSES = tuple(f"geometry_msgs/msg/{kind}" for kind in ("PoseStamped", "PoseWithCovarianceStamped", "TransformStamped"))
ODOMETRY = "nav_msgs/msg/Odometry"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
ARRAY = "std_msgs/msg/Float64MultiArray"
STATIC = "/tf_static"
STAMPS: Final = "stamps"  # option that selects one of a message's two times
RECEIVED: Final = "received"


@final
@dataclass(frozen=True)
class JointTrack:
    """Readings or commands of joints over time."""

    time_s: Array  # sorted, (n,) [s]
    q: Array  # (n, j) [rad] or [m]
    qd: Array | None  # (n, j), or None where a message has none
    effort: Array | None  # (n, j) [Nm] or [N], likewise
    partial: int  # number of skipped messages, which lack a joint


@final
@dataclass(frozen=True)
class Transforms:
    """The tree of frames that ROS calls tf, over time."""

    file: str  # their file
    parents: Mapping[str, str]  # of each frame
    # T_parent_frame of each frame, (n, 4, 4), and its times, sorted, (n,) [s]; one motion without a time: it is static
    motions: Mapping[str, tuple[Array, Array]]

    def lookup(self, target: str, source: str, at_s: Array, tolerance_s: float) -> tuple[Array, Bools, Array]:
        """T_target_source at times (m,), (m, 4, 4), whether all frames were known then, (m,), and how far off, (m,)."""
        known, away = np.ones(len(at_s), dtype=bool), np.zeros(len(at_s))
        motions = []
        for chain in self._chains(target, source):
            T = np.broadcast_to(np.eye(4), (len(at_s), 4, 4))
            for frame in chain:
                moved, time_s = self.motions[frame]
                if len(time_s):
                    found = match(time_s, at_s, tolerance_s)
                    known &= found.near
                    away = np.maximum(away, found.away_s)
                    moved = found.motions(moved)
                T = moved @ T
            motions.append(T)
        return inverse(motions[0]) @ motions[1], known, away

    def times(self, target: str, source: str) -> Array:
        """Times at which the source was seen from the target: those of the moving frame nearest to the source."""
        up, down = self._chains(target, source)
        for frame in (*down, *reversed(up)):
            _, time_s = self.motions[frame]
            if len(time_s):
                return time_s
        raise DataError(f"{self.file}: nothing moves between the frames {target} and {source}.", file=self.file)

    def _chains(self, target: str, source: str) -> tuple[list[str], list[str]]:
        """Frames from each of the two up to their first common one, without it."""
        up, down = self._above(target), self._above(source)
        shared = [frame for frame in up if frame in down]
        if not shared:
            raise DataError(f"{self.file}: the frames {target} and {source} are in separate trees.", file=self.file)
        return up[: up.index(shared[0])], down[: down.index(shared[0])]

    def _above(self, frame: str) -> list[str]:
        """The frame and all above it, up to the root."""
        known = {*self.parents, *self.parents.values()}
        if frame not in known:
            raise DataError(f"{self.file} has no frame {frame} in tf.{near(frame, sorted(known), 12)}", file=self.file)
        found = [frame]
        while found[-1] in self.parents:
            found.append(self.parents[found[-1]])
            if len(found) > len(self.parents) + 1:
                raise DataError(f"{self.file}: the frames above {frame} form a loop.", file=self.file)
        return found


@final
@dataclass(frozen=True)
class Bag:
    """An open recording."""

    file: str  # its name, for messages
    reader: Any  # of rosbags
    received: bool  # whether times are those of the recorder, not of the messages' headers

    @classmethod
    @contextmanager
    def opened(cls, paths: Sequence[Path], stamps: str | None) -> Iterator[Self]:
        """Open a ROS 1 bag or several, or a ROS 2 bag: a folder, or a .db3 or .mcap file alone."""
        if stamps not in (None, RECEIVED):
            raise UsageError(f"--set {STAMPS}={stamps}: expected {RECEIVED}; otherwise the messages' own times count.")
        missing = "A ROS bag needs the package rosbags: pip install 'robolaser[ros]'"
        bags, types = (extra(f"rosbags.{module}", missing) for module in ("highlevel", "typesys"))
        file = ", ".join(path.name for path in paths)
        try:
            with bags.AnyReader(paths, default_typestore=types.get_typestore(types.Stores.ROS2_HUMBLE)) as reader:
                yield cls(file, reader, stamps == RECEIVED)
        except RobolaserError:
            raise
        except Exception as error:  # of any type for a damaged file
            reason = " ".join(str(error).split())[:300] or type(error).__name__
            raise DataError(f"{file}: the recording cannot be read: {reason}", file=file) from None

    def topics(self, *types: str) -> list[str]:
        """Topics of these types."""
        return sorted({str(one.topic) for one in self.reader.connections if one.msgtype in types})

    def topic(self, option: str, stated: str | None, *types: str) -> str:
        """The stated topic, or the only one of these types."""
        there = self.topics(*types)
        kind = types[0].rpartition("/")[2]
        if stated is not None and stated not in there:
            raise DataError(f"{self.file} has no topic {stated} of type {kind}.{near(stated, there)}", file=self.file)
        if stated is None and len(there) > 1:
            raise UsageError(f"{self.file}: which topic? State it with --set {option}=TOPIC: {', '.join(there)}.")
        if not there:
            every = ", ".join(sorted({str(one.topic) for one in self.reader.connections})) or "none"
            raise DataError(f"{self.file} has no topic of type {kind}. There are: {every}.", file=self.file)
        return stated or there[0]

    def messages(self, topics: Sequence[str]) -> Iterator[tuple[str, float, Any]]:
        """Topic, time it was received [s], and message."""
        connections = [one for one in self.reader.connections if one.topic in topics]
        for connection, received, raw in self.reader.messages(connections=connections):
            yield connection.topic, received * 1e-9, self.reader.deserialize(raw, connection.msgtype)

    def time_of(self, header: Any, received_s: float, topic: str) -> float:
        """Time of a message [s]: of its header, where it has one."""
        if self.received or header is None:
            return received_s
        time = header.stamp.sec + header.stamp.nanosec * 1e-9
        if time <= 0:
            raise DataError(
                f"{self.file}, topic {topic}: its messages have no time stamps. Take the times at which they were"
                f" recorded with --set {STAMPS}={RECEIVED}.",
                file=self.file,
            )
        return float(time)

    def joints(self, topic: str, names: Sequence[str], *, commanded: bool = False) -> JointTrack:
        """Readings of joints, in the order of the names; or their commands, where a message has both."""
        rows: dict[float, Array] = {}  # positions, velocities and efforts, (3, j), NaN where a message lacks them
        seen: dict[str, None] = {}
        partial = 0
        for _, received, message in self.messages([topic]):
            there, *numbers = _of_joints(message, names, commanded=commanded)
            seen |= dict.fromkeys(there)
            if not set(names) <= set(there):
                partial += 1
                continue
            lacking = [np.nan] * len(there)
            row = np.array([values if len(values) == len(there) else lacking for values in numbers], dtype=np.float64)
            row = row[:, [there.index(name) for name in names]]
            if np.isfinite(row[0]).all():
                rows[self.time_of(getattr(message, "header", None), received, topic)] = row
        if not rows:
            missing = [name for name in names if name not in seen]
            what = f"lacks the joint {missing[0]}" if missing else "has no message with all joints of the robot"
            raise DataError(f"{self.file}, topic {topic} {what}.{near((missing or [''])[0], seen)}", file=self.file)
        times = sorted(rows)
        q, *others = np.stack([rows[time] for time in times], axis=1)
        qd, effort = (values if np.isfinite(values).all() else None for values in others)
        return JointTrack(np.array(times), q, qd, effort, partial)

    def transforms(self) -> Transforms:
        """All frames of the topics of tf."""
        parents: dict[str, str] = {}
        found: dict[str, dict[float | None, Array]] = {}
        for topic, received, message in self.messages(self.topics(*TF)):
            for one in message.transforms:
                parent, frame = one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")
                if parents.setdefault(frame, parent) != parent:
                    reason = f"{self.file}: the frame {frame} is placed on {parents[frame]} and on {parent}."
                    raise DataError(reason, file=self.file)
                time = None if topic.endswith(STATIC) else self.time_of(one.header, received, topic)
                found.setdefault(frame, {})[time] = self._motion(one.transform, topic)
        motions = {}
        for frame, by_time in found.items():
            times = sorted(time for time in by_time if time is not None)
            motions[frame] = np.array([by_time[time] for time in times] or [by_time[None]]), np.array(times)
        return Transforms(self.file, parents, motions)

    def poses(self, topic: str) -> tuple[Array, Array]:
        """Times (n,) [s], sorted, and motions (n, 4, 4) of a topic of poses."""
        found: dict[float, Array] = {}
        for _, received, message in self.messages([topic]):
            stated = message.transform if hasattr(message, "transform") else message.pose
            stated = stated.pose if hasattr(stated, "pose") else stated  # with its covariance
            found[self.time_of(message.header, received, topic)] = self._motion(stated, topic)
        times = sorted(found)
        return np.array(times), np.array([found[time] for time in times]).reshape(-1, 4, 4)

    def _motion(self, stated: Any, topic: str) -> Array:
        """A message's transform, or its pose."""
        fields = ("translation", "rotation") if hasattr(stated, "translation") else ("position", "orientation")
        at, turned = (getattr(stated, field) for field in fields)
        seven = np.array([at.x, at.y, at.z, turned.x, turned.y, turned.z, turned.w], dtype=np.float64)
        return motion_of_seven(seven, self.file, f"topic {topic}")


def _of_joints(message: Any, names: Sequence[str], *, commanded: bool) -> tuple[list[str], Any, Any, Any]:
    """Names of joints in a message, and their positions, velocities and efforts, each empty where it has none."""
    if hasattr(message, "data"):
        return list(names[: len(message.data)]), message.data, (), ()
    if hasattr(message, "joint_names"):  # a controller's state, by its names since and before ROS 2 Iron
        sides = ("reference", "desired") if commanded else ("feedback", "actual")
        point = next(getattr(message, side) for side in sides if hasattr(message, side))
        return list(message.joint_names), point.positions, point.velocities, point.effort
    return list(message.name), message.position, message.velocity, message.effort
