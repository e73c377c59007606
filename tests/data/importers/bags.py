"""ROS bags of a cell, written by rosbags in the format of ROS."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

rosbags = pytest.importorskip("rosbags")
from rosbags import rosbag1, rosbag2  # noqa: E402
from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

from robolaser.geometry.rigid_motion import to_quaternion  # noqa: E402

START_S = 1_600_000_000
FORMATS = ("bag", "db3", "mcap")


class Recorder:
    """Writes messages of ROS 1 or ROS 2 to a bag."""

    def __init__(self, writer: Any, store: Any, *, one: bool) -> None:
        self.writer, self.store, self.one = writer, store, one
        self.connections: dict[str, Any] = {}

    def header(self, time_s: float, frame: str = "") -> Any:
        kinds = self.store.types
        stamp = kinds["builtin_interfaces/msg/Time"](int(time_s), round(time_s % 1 * 1e9))
        return kinds["std_msgs/msg/Header"](*([0] if self.one else []), stamp, frame)

    def write(self, topic: str, kind: str, time_s: float, *fields: Any) -> None:
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        message = self.store.types[kind](*fields)
        data = self.store.serialize_ros1(message, kind) if self.one else self.store.serialize_cdr(message, kind)
        self.writer.write(self.connections[topic], round(time_s * 1e9), data)

    def joints(
        self, time_s: float, names: list[str], q: np.ndarray, qd: np.ndarray, topic: str = "/joint_states"
    ) -> None:
        header = self.header(time_s)
        self.write(topic, "sensor_msgs/msg/JointState", time_s + 0.002, header, names, q, qd, np.empty(0))

    def transform(self, T: np.ndarray) -> Any:
        kinds = self.store.types
        place = kinds["geometry_msgs/msg/Vector3"](*T[:3, 3].tolist())
        return kinds["geometry_msgs/msg/Transform"](
            place, kinds["geometry_msgs/msg/Quaternion"](*to_quaternion(T[:3, :3]).tolist())
        )

    def frame(self, time_s: float, parent: str, child: str, T: np.ndarray, topic: str = "/tf") -> None:
        stamped = self.store.types["geometry_msgs/msg/TransformStamped"]
        rows = [stamped(self.header(time_s, parent), child, self.transform(T))]
        self.write(topic, "tf2_msgs/msg/TFMessage", time_s + 0.002, rows)

    def pose(self, topic: str, time_s: float, T: np.ndarray) -> None:
        kinds = self.store.types
        place = kinds["geometry_msgs/msg/Point"](*T[:3, 3].tolist())
        turn = kinds["geometry_msgs/msg/Quaternion"](*to_quaternion(T[:3, :3]).tolist())
        stated = kinds["geometry_msgs/msg/Pose"](place, turn)
        self.write(topic, "geometry_msgs/msg/PoseStamped", time_s + 0.002, self.header(time_s, "world"), stated)

    def image(self, topic: str, time_s: float, pixels: np.ndarray, encoding: str = "mono8") -> None:
        rows = np.ascontiguousarray(pixels)
        step = rows.strides[0]
        fields = (self.header(time_s, "camera"), *rows.shape[:2], encoding, 0, step, rows.view(np.uint8).ravel())
        self.write(topic, "sensor_msgs/msg/Image", time_s + 0.002, *fields)


@contextmanager
def recorder(folder: Path, kind: str) -> Iterator[tuple[Path, Recorder]]:
    """A bag of that kind: its path and its recorder."""
    if kind == "bag":
        path = folder / "cell.bag"
        with rosbag1.Writer(path) as writer:
            store = get_typestore(Stores.ROS1_NOETIC)
            tf = "tf2_msgs/msg/TFMessage"
            store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", tf))
            yield path, Recorder(writer, store, one=True)
    else:
        path = folder / "cell"
        plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
        with rosbag2.Writer(path, version=9, storage_plugin=plugin) as writer:
            yield path, Recorder(writer, get_typestore(Stores.ROS2_HUMBLE), one=False)
