"""Recordings of ROS 1 and ROS 2: the arm's readings, and images of a board or poses of a marker or body."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.bounded_reading import decoded
from robolaser.data.csv_tables import finite
from robolaser.data.dataset import Poses
from robolaser.data.importers.hand_eye_pairs import MOUNT, Pairs, mount_of, pairs_dataset
from robolaser.data.importers.image_folder import BOARD, board_of, camera_recording
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.ros_messages import IMAGES, JOINTS, ODOMETRY, POSES, STAMPS, Bag
from robolaser.data.importers.time_matching import TOLERANCE, match, tolerance_of, with_readings
from robolaser.data.result_folder import Contents
from robolaser.errors import DataError, UsageError

SUFFIXES = (".bag", ".db3", ".mcap")
JOINT_TOPIC: Final = "joints"
IMAGE_TOPIC: Final = "images"
POSE_TOPIC: Final = "poses"
CAMERA: Final = "camera"
MARKER: Final = "marker"
BASE: Final = "base"
FLANGE: Final = "flange"
EVERY: Final = "every_s"
MOST_IMAGES = 5000
ENCODINGS = {
    **dict.fromkeys(("mono8", "8UC1", "mono16", "16UC1"), (1, "")), "bgr8": (3, ""), "8UC3": (3, ""),
    "rgb8": (3, "RGB"), "rgba8": (4, "RGBA"), "bgra8": (4, "BGRA"), "bayer_rggb8": (1, "BayerBG"),
    "bayer_bggr8": (1, "BayerRG"), "bayer_gbrg8": (1, "BayerGR"), "bayer_grbg8": (1, "BayerGB"),
}  # fmt: skip
"""Channels, and OpenCV's name for their conversion to blue, green and red.

ROS names a pattern by its first row, OpenCV by its second row's second and third pixels."""


@final
class RosBag(Importer):
    """A bag with joint states, or tf with the flange, and images of a board, a marker in tf, or a topic of poses.

    Measurements are kept, each with the arm's readings at its time, interpolated between those before and after it,
    which must be within the stated tolerance. Velocities of the joint states become `qd_` columns.
    """

    name = "rosbag"
    title = "ROS 1 bags, ROS 2 bags and MCAP files: joint states or tf, and images, markers or poses"
    further = (
        MOUNT, TOLERANCE, EVERY, STAMPS, JOINT_TOPIC, BASE, FLANGE, IMAGE_TOPIC, BOARD, CAMERA, MARKER, POSE_TOPIC,
    )  # fmt: skip
    takes = ("robot",)

    def recognises(self, path: Path) -> bool:
        """By its suffix, or as a folder with a file of one of those suffixes."""
        return any(file.suffix in SUFFIXES for file in (path.iterdir() if path.is_dir() else [path]))

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read the measurements, and the arm's readings at their times."""
        with Bag.opened(paths, options.further.get(STAMPS)) as bag:
            stated = [name for name in (IMAGE_TOPIC, MARKER, POSE_TOPIC) if name in options.further]
            images, poses = bag.topics(*IMAGES), bag.topics(*POSES, ODOMETRY)
            if len(stated) > 1:
                raise UsageError(f"--set {stated[0]} and --set {stated[1]}: import one measurement after the other.")
            if not stated and (len(images) != 1 or poses):
                raise UsageError(
                    f"{bag.file}: what was measured? State it with --set {IMAGE_TOPIC}=TOPIC"
                    f" ({', '.join(images) or 'there are none'}), --set {POSE_TOPIC}=TOPIC"
                    f" ({', '.join(poses) or 'there are none'}), or --set {CAMERA}=FRAME --set {MARKER}=FRAME of tf."
                )
            if not stated or stated == [IMAGE_TOPIC]:
                return _images(bag, options)
            return _pairs(bag, options)


def _pairs(bag: Bag, options: ImportOptions) -> Imported:
    """Poses of a marker in tf, or of a topic."""
    mount, tolerance = mount_of(options, bag.file), tolerance_of(options.further, bag.file)
    if POSE_TOPIC in options.further:
        origin = options.further[POSE_TOPIC]
        times, T = bag.poses(bag.topic(POSE_TOPIC, origin, *POSES, ODOMETRY))
        seen = np.ones(len(times), dtype=bool)
    else:
        marker, camera = options.further[MARKER], _frame(CAMERA, options, bag, "that the marker is seen from")
        tree = bag.transforms()
        times = tree.times(camera, marker)
        T, seen, _ = tree.lookup(camera, marker, times, tolerance)
        origin = f"tf, {camera} to {marker}"
    picked = np.flatnonzero(seen)[_thinned(times[seen], options)]
    arm, poses, kept, left_out = _readings(bag, options, times[picked], tolerance, "pose")
    return pairs_dataset(Pairs(bag.file, poses, T[picked][kept], arm, origin), mount, options, left_out)


def _images(bag: Bag, options: ImportOptions) -> Imported:
    topic = bag.topic(IMAGE_TOPIC, options.further.get(IMAGE_TOPIC), *IMAGES)
    mount, board = mount_of(options, bag.file), board_of(options.further, bag.file)
    tolerance = tolerance_of(options.further, bag.file)
    times = np.array([bag.time_of(one.header, received, topic) for _, received, one in bag.messages([topic])])
    order = np.argsort(times, kind="stable")
    picked = order[_thinned(times[order], options)]
    arm, poses, kept, left_out = _readings(bag, options, times[picked], tolerance, "image")
    wanted = dict(zip(picked[kept].tolist(), poses.names, strict=True))
    if len(wanted) > MOST_IMAGES:
        raise UsageError(f"{bag.file} has {len(wanted)} images. Take fewer with --set {EVERY}=SECONDS.")
    paths: dict[str, str] = {}
    contents: dict[str, Contents] = {}
    sizes = set()
    for number, (_, _, message) in enumerate(bag.messages([topic])):
        if number in wanted:
            suffix, data, size = _image_file(message, bag.file, topic)
            paths[wanted[number]] = path = f"images/{wanted[number]}{suffix}"
            contents[path] = data
            sizes.add(size)
    if len(sizes) != 1:
        raise DataError(f"{bag.file}, topic {topic}: images of several sizes: {sizes}.", file=bag.file)
    poses = replace(poses, image=tuple(paths[name] for name in poses.names))
    dataset = camera_recording(poses, sizes.pop(), board, mount, options, source=bag.file)
    read_from = {"poses.csv": {"pose": "(number of the image)", "image": topic, "": arm}}
    return Imported(dataset, read_from, left_out, contents)


def _readings(
    bag: Bag, options: ImportOptions, at_s: Array, tolerance: float, what: str
) -> tuple[str, Poses, Ints, tuple[str, ...]]:
    """The arm at times (m,), from joint states where there is a robot, else from tf.

    Returns:
        Its topic or frames; its poses at the times that have readings within the tolerance, (k,); the numbers of these
        times, (k,); and messages on the others.
    """
    qd = T = q = None
    left_out: list[str] = []
    if options.robot is not None:
        origin = bag.topic(JOINT_TOPIC, options.further.get(JOINT_TOPIC), JOINTS)
        track = bag.joints(origin, options.robot.joints)
        found = match(track.time_s, at_s, tolerance)
        known, away = found.near, found.away_s
        q, qd = found.values(track.q), None if track.qd is None else found.values(track.qd)
        if track.partial:
            left_out.append(f"{bag.file}: {track.partial} messages of {origin} that lack a joint of the robot")
        if qd is None:
            left_out.append(f"{bag.file}: velocities of {origin} (not all messages have them)")
    else:
        base = _frame(BASE, options, bag, "of the robot's base (or name the robot with --robot)")
        flange = _frame(FLANGE, options, bag, "of the flange")
        origin = f"tf, {base} to {flange}"
        T, known, away = bag.transforms().lookup(base, flange, at_s, tolerance)
    kept, without = with_readings(known, away, tolerance, file=bag.file, what=what, source=origin)
    poses = Poses(("",) * len(at_s), at_s, q, qd, T).take(kept)
    names = tuple(f"{i:05d}" for i in range(1, len(kept) + 1))
    return origin, replace(poses, names=names), kept, (*left_out, *without)


def _frame(option: str, options: ImportOptions, bag: Bag, which: str) -> str:
    if option not in options.further:
        raise UsageError(f"{bag.file}: which frame of tf is the one {which}? State it with --set {option}=FRAME.")
    return options.further[option]


def _thinned(times: Array, options: ImportOptions) -> Ints:
    """Numbers of the times that are at least `every_s` apart."""
    step = finite(options.further.get(EVERY, "0"))
    if not step >= 0:
        raise UsageError(f"--set {EVERY}={options.further[EVERY]}: expected seconds.")
    kept, last = [], -np.inf
    for number, time in enumerate(times.tolist()):
        if time - last >= step:
            kept.append(number)
            last = time
    return np.array(kept, dtype=np.int64)


def _image_file(message: Any, file: str, topic: str) -> tuple[str, bytes, tuple[int, int]]:
    """Suffix, contents and size [px] of the file of a message."""
    import cv2  # noqa: PLC0415 - slow to import

    if not hasattr(message, "encoding"):
        data = np.asarray(message.data, dtype=np.uint8)
        image = decoded(data.tobytes(), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise DataError(f"{file}, topic {topic}: an image of format {message.format} cannot be read.", file=file)
        suffix = ".png" if "png" in message.format.lower() else ".jpg"
        return suffix, bytes(message.data), (image.shape[1], image.shape[0])
    encoding = message.encoding
    if encoding not in ENCODINGS:
        raise DataError(f"{file}, topic {topic}: no support for images of encoding {encoding!r}.", file=file)
    kind = np.dtype(np.uint16 if "16" in encoding else np.uint8).newbyteorder(">" if message.is_bigendian else "<")
    channels, turned = ENCODINGS[encoding]
    data = np.asarray(message.data, dtype=np.uint8)
    if len(data) != message.step * message.height or message.step < message.width * channels * kind.itemsize:
        raise DataError(f"{file}, topic {topic}: an image has fewer bytes than its size says.", file=file)
    rows = data.reshape(message.height, message.step)[:, : message.width * channels * kind.itemsize]
    image = np.ascontiguousarray(rows).view(kind).astype(kind.newbyteorder("="))
    image = image.reshape(message.height, message.width, channels)
    if turned:
        image = cv2.cvtColor(image, getattr(cv2, f"COLOR_{turned}2BGR"))
    _, png = cv2.imencode(".png", image)
    return ".png", png.tobytes(), (message.width, message.height)
