"""From the stripes of a recording to points in the base frame, piece by piece on all cores.

`std` of a point is the root-mean-square distance by which its noise moves it: the line centre's standard deviation
across the stripe, propagated through ray and laser plane, and the noise of the joints, propagated through the arm. The
latter is the calibration's estimate: the readings' noise, and unexplained scatter of single poses. Where
that is large, points scatter less against their neighbours. Errors of the calibration that all points share are not
included.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from robolaser.arrays import Array, Ints, Progress
from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import PoseImages, images_of_poses
from robolaser.data.stripe_file import FILE, STRIPE, Stripes, open_stripes
from robolaser.data.subsampling import evenly
from robolaser.errors import DataError, ScanError, unreadable
from robolaser.geometry.rigid_motion import apply
from robolaser.model.stages import Stage
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.ply import VERTEX, Vertices
from robolaser.scan.scanner_model import ScannerModel

AT_ONCE = 1 << 14  # line centres of a core at a time: they and their points fit into its cache
SAMPLES = 2000  # line centres for the sizes of possible errors
PIECES_AT_ONCE = 32  # for each core, in a batch


@final
@dataclass(frozen=True)
class Source:
    """The stripes of a recording."""

    what: str  # their source, for messages
    pieces: Sequence[Callable[[], Stripes]]  # each returns some line centres, in any thread, (n,) of STRIPE
    points: Points | None = None  # the rows of points.csv, where these are the only piece; else None


def source_of(recording: Dataset, pixel_px: float) -> Source:
    """The stripes of a recording on disk: from stripes.npy, else points.csv, else images.

    Line centres whose standard deviation is not known have that of `pixel_px`.

    Raises:
        ScanError: There is none of them, or stripes.npy is empty.
        DataError: stripes.npy is broken, or the image columns of poses.csv are invalid.
    """
    folder = recording.folder
    if folder is not None and (folder / FILE).exists():
        return _from_file(folder / FILE)
    rows = np.sort(np.concatenate([one.rows for one in recording.sensors if one.data.kind == recording.kind]))
    if len(rows):  # without a board's corners, which are on no stripe
        points = recording.points.take(rows)
        return Source("points.csv", [partial(_from_points, points, pixel_px)], points)
    shots = images_of_poses(recording)
    if not shots:
        raise ScanError(
            f"{folder} has neither stripes.npy nor points.csv nor images named in poses.csv: there is nothing to scan."
            " Record images, or run `robolaser extract` on them."
        )
    from robolaser.vision.stripe_trace import StripeSearch  # noqa: PLC0415 - OpenCV is slow to load

    search = StripeSearch.of(recording, shots)
    return Source("images", [partial(_found, search, one) for one in shots])


def sample_points(source: Source, recording: Dataset) -> Points:
    """Evenly taken line centres of the whole recording; for images, which are not read yet, pixels all over them."""
    if source.what == "images":
        return points_in_images(recording, np.array([shots.row for shots in images_of_poses(recording)]))
    if source.points is not None:
        return source.points.take(evenly(len(source.points), SAMPLES))
    assert recording.folder is not None  # it has stripes.npy
    stripes = open_stripes(recording.folder / FILE)
    some = stripes[evenly(len(stripes), SAMPLES)]
    _check_poses(some, recording)
    return as_points(some)


def points_in_images(recording: Dataset, rows: Ints) -> Points:
    """Pixels all over the image in some of the poses with these numbers, (n,)."""
    assert recording.image_px is not None  # data sets of stripes have an image size
    grid = np.linspace(0.2, 0.8, 3)
    places = np.stack(np.meshgrid(*(side * grid for side in recording.image_px)), axis=-1).reshape(-1, 2)
    some = rows[evenly(len(rows), SAMPLES // len(places))]
    return Points(some.repeat(len(places)), (), pixel=np.tile(places, (len(some), 1)))


def as_points(stripes: Stripes) -> Points:
    """Line centres as points of a data set; they have no names."""
    pixel = np.empty((len(stripes), 2))
    pixel[:, 0], pixel[:, 1] = stripes["u"], stripes["v"]
    return Points(stripes["pose"].astype(np.int64), (), pixel=pixel)


def _check_poses(stripes: Stripes, recording: Dataset) -> None:
    """Check that all line centres have a pose."""
    last = int(stripes["pose"].max(initial=0))
    if len(stripes) and last >= len(recording.poses):
        raise DataError(
            f"{FILE} of {recording.folder} has line centres of row {last} of poses.csv, whose rows are 0 to"
            f" {len(recording.poses) - 1}. They do not belong to one recording: run `robolaser extract --force` again.",
            file=FILE,
        )


def no_line_centres(source: str) -> ScanError:
    """The error of a recording without a stripe."""
    return ScanError(
        f"No image shows a stripe: there is no line centre in {source}. Check that the laser was on, the exposure, and"
        " [sensor] stripe_axis; then record again, or run `robolaser extract --force`."
    )


def _from_file(path: Path) -> Source:
    """Pieces of a file, each read when needed: memory use would seem to grow with a mapped file."""
    stripes = open_stripes(path)
    if not isinstance(stripes, np.memmap):
        raise no_line_centres(str(path))
    start, count = stripes.offset, len(stripes)
    return Source(FILE, [partial(_read, path, start, first, count) for first in range(0, count, AT_ONCE)])


def _read(path: Path, start: int, first: int, count: int) -> Stripes:
    most = min(AT_ONCE, count - first)
    try:
        piece = np.fromfile(path, STRIPE, most, offset=start + first * STRIPE.itemsize)
    except OSError as error:
        raise unreadable(path, error.strerror or str(error)) from None
    if len(piece) < most:
        raise unreadable(path, "it became shorter while it was read")
    return piece


def _found(search: "StripeSearch", one: PoseImages) -> Stripes:
    return np.asarray(np.concatenate(list(search.traces(one))))


def _from_points(points: Points, pixel_px: float) -> Stripes:
    stripes = np.empty(len(points), STRIPE)
    stripes["pose"], stripes["std"], stripes["intensity"] = points.pose, pixel_px, np.nan
    stripes["u"], stripes["v"] = points["pixel"].T
    return stripes


@final
@dataclass
class Counts:
    """Numbers of line centres, of their points, and of poses with points."""

    centres: int = 0
    points: int = 0
    poses: int = 0


@final
@dataclass(frozen=True)
class ScannedRecording:
    """The points of a scanner in one recording."""

    scanner: ScannerModel  # of the recording
    source: Source  # the stripes
    arm: Array  # scatter by the noise of the joints' readings at each pose, (n,) [m]

    def piece(self, read: Callable[[], Stripes]) -> tuple[int, Vertices]:
        """The number of line centres in a piece of the source, and their points."""
        stripes = read()
        _check_poses(stripes, self.scanner.dataset)
        points = self.source.points or as_points(stripes)
        places = self.scanner.in_base(points)
        across = stripes["std"] * self.scanner.slope(points)
        out = np.empty(len(stripes), VERTEX)
        out["x"], out["y"], out["z"] = places.T
        out["std"] = np.hypot(across, self.arm[points.pose])
        out["pose"], out["intensity"] = stripes["pose"], stripes["intensity"]
        return len(stripes), out[np.isfinite(places).all(axis=1)]


@final
@dataclass(frozen=True)
class Cloud:
    """The points of one or several recordings, with poses numbered consecutively.

    Attributes:
        parts: Each recording.
        counts: Numbers of line centres and points so far.

    Examples:
        >>> sum(len(piece) for piece in scan.cloud.pieces())
        25
    """

    parts: tuple[ScannedRecording, ...]
    counts: Counts = field(default_factory=Counts)

    @property
    def what(self) -> str:
        """The source of the stripes, for messages."""
        return " and ".join(dict.fromkeys(part.source.what for part in self.parts))

    @property
    def cameras(self) -> Array:
        """Positions of the camera in the base frame by pose, (n, 3) [m]."""
        return np.concatenate([part.scanner.camera[:, :3, 3] for part in self.parts])

    def pieces(self, progress: Progress | None = None) -> Iterator[Vertices]:
        """The points in the order of the line centres; rays that do not meet the laser plane are left out.

        Args:
            progress: Called with the finished share.

        Raises:
            DataError: Line centres are of poses that their recording does not have.
            ScanError: No image of a recording shows a stripe, or no line centre gave a point.
            RobolaserError: A file or an image cannot be read.
        """
        self.counts.centres = self.counts.points = self.counts.poses = 0
        first_pose = 0
        for number, part in enumerate(self.parts):
            poses = len(part.scanner.dataset.poses)
            before, seen = replace(self.counts), np.zeros(poses, dtype=bool)
            for share, (centres, piece) in _in_threads(part):
                self.counts.centres += centres
                self.counts.points += len(piece)
                seen[piece["pose"]] = True
                piece["pose"] += first_pose
                yield piece
                if progress is not None:
                    progress("scanning", (number + share) / len(self.parts))
            self.counts.poses += int(seen.sum())
            first_pose += poses
            if self.counts.centres == before.centres:
                raise no_line_centres(part.source.what)
            if self.counts.points == before.points:
                raise ScanError(
                    f"For none of {self.counts.centres - before.centres} line centres does the ray meet the laser plane"
                    " in front of the camera. Check stripe_axis, and that calibration and recording belong to the same"
                    " scanner."
                )


def _in_threads(part: ScannedRecording) -> Iterator[tuple[float, tuple[int, Vertices]]]:
    """The pieces of a part in order, computed on all cores, each with the finished share."""
    waiting, done, count = iter(part.source.pieces), 0, len(part.source.pieces)
    with ThreadPoolExecutor(cores(), thread_name_prefix="robolaser") as threads:
        while batch := list(islice(waiting, PIECES_AT_ONCE * cores())):
            for found in threads.map(part.piece, batch):
                done += 1
                yield done / count, found


def cores() -> int:
    """Cores that a scan may use: all of this process, or `OMP_NUM_THREADS`."""
    limit = os.environ.get("OMP_NUM_THREADS", "")
    if limit.isdigit() and int(limit) > 0:
        return int(limit)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def arm_scatter(scanner: ScannerModel, calibrated: Calibrated) -> Array:
    """Scatter of a pose's points from the noise of joint readings, or of measured flange poses, (n,) [m].

    At the point where the optical axis meets the laser plane. Zeros where the calibration has no such noise.
    """
    poses, robot = scanner.dataset.poses, scanner.dataset.robot
    if robot is None or poses.q is None:
        return np.full(len(poses), np.sqrt(3.0) * calibrated.noise.get("flange", 0.0))
    sigma = calibrated.noise.get("joint", 0.0)
    axis = replace(scanner, effects=tuple(one for one in scanner.effects if one.stage is not Stage.PIXELS))
    seen = np.nan_to_num(axis.in_camera(axis.at_poses))  # without an intersection: the camera's position
    points = apply(scanner.camera, seen)
    moves = robot.jacobian(poses.q, points[None])[:, :3, list(robot.chain)]  # by each joint, (n, 3, j)
    return np.asarray(sigma * np.linalg.norm(np.linalg.norm(moves, axis=1), axis=1))


if TYPE_CHECKING:
    from robolaser.vision.stripe_trace import StripeSearch
