"""From the stripes of a recording to points in the base frame, piece by piece on all cores.

`std` of a point is the root-mean-square distance by which its noise moves it: the line centre's standard deviation
across the stripe, propagated through ray and laser plane, and the noise of the joints, propagated through the arm. The
latter is the calibration's estimate: the readings' noise, and whatever moved single poses unexplained. Where
that is much, points scatter less against their neighbours. Errors of the calibration that all points share are not in
it.
"""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import final

import numpy as np

from robolaser.arrays import Array, Progress
from robolaser.data.stripe_file import Stripes
from robolaser.errors import ScanError
from robolaser.geometry.rigid_motion import apply
from robolaser.model.stages import Stage
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.ply import VERTEX, Vertices
from robolaser.scan.scanner_model import ScannerModel
from robolaser.scan.sources import Source, as_points, check_poses, no_line_centres

PIECES_AT_ONCE = 32  # for each core, before they are handed on in order


@final
@dataclass
class Counts:
    """Numbers of line centres, of points that they gave, and of poses with points."""

    centres: int = 0
    points: int = 0
    poses: int = 0


@final
@dataclass(frozen=True)
class ScannedRecording:
    """The points that a scanner shows of one recording."""

    scanner: ScannerModel  # what the scanner sees
    source: Source  # the stripes
    arm: Array  # scatter from the noise of the joints' readings at each pose, (n,) [m]

    def piece(self, read: Callable[[], Stripes]) -> tuple[int, Vertices]:
        """How many line centres a piece of the source has, and the points that they give."""
        stripes = read()
        check_poses(stripes, self.scanner.dataset)
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
        counts: Counts what passes.

    Examples:
        >>> from robolaser.scan import prepare, read_calibration
        >>> robolaser.calibrate(dataset).save("for_cloud")
        >>> cloud = prepare(read_calibration("for_cloud"), dataset).cloud
        >>> sum(len(piece) for piece in cloud.pieces())
        25
    """

    parts: tuple[ScannedRecording, ...]
    counts: Counts = field(default_factory=Counts)

    @property
    def what(self) -> str:
        """Where the stripes come from, for people."""
        return " and ".join(dict.fromkeys(part.source.what for part in self.parts))

    @property
    def cameras(self) -> Array:
        """Positions of the camera in the base frame by pose, (n, 3) [m]."""
        return np.concatenate([part.scanner.camera[:, :3, 3] for part in self.parts])

    def pieces(self, progress: Progress | None = None) -> Iterator[Vertices]:
        """The points in the order of the line centres; rays that do not meet the laser plane are left out.

        Args:
            progress: Is called with the share that is done.

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
    """The pieces of a part in their order, computed on all cores, each with the share that is done."""
    waiting, done, count = iter(part.source.pieces), 0, len(part.source.pieces)
    with ThreadPoolExecutor(cores(), thread_name_prefix="robolaser") as threads:
        while batch := list(islice(waiting, PIECES_AT_ONCE * cores())):
            for found in threads.map(part.piece, batch):
                done += 1
                yield done / count, found


def cores() -> int:
    """Cores that a scan may use: all of this process, or as many as `OMP_NUM_THREADS` says."""
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
    seen = np.nan_to_num(axis.in_camera(axis.at_poses))  # where none is seen: the camera's position
    points = apply(scanner.camera, seen)
    moves = robot.jacobian(poses.q, points[None])[:, :3, list(robot.chain)]  # by each joint, (n, 3, j)
    return np.asarray(sigma * np.linalg.norm(np.linalg.norm(moves, axis=1), axis=1))
