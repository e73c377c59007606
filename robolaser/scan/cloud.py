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
class Cloud:
    """The points that a scanner shows of a source.

    Attributes:
        scanner: What the scanner sees.
        source: The stripes.
        arm: Scatter from the noise of the joints' readings at each pose, (n,) [m].
        counts: Counts what passes.

    Examples:
        >>> from robolaser.scan import prepare, read_calibration
        >>> robolaser.calibrate(dataset).save("for_cloud")
        >>> cloud = prepare(read_calibration("for_cloud"), dataset).cloud
        >>> sum(len(piece) for piece in cloud.pieces())
        25
    """

    scanner: ScannerModel
    source: Source
    arm: Array
    counts: Counts = field(default_factory=Counts)

    @property
    def what(self) -> str:
        """Where the stripes come from, for people."""
        return self.source.what

    @property
    def cameras(self) -> Array:
        """Positions of the camera in the base frame by pose, (n, 3) [m]."""
        return self.scanner.camera[:, :3, 3]

    def pieces(self, progress: Progress | None = None) -> Iterator[Vertices]:
        """The points in the order of the line centres; rays that do not meet the laser plane are left out.

        Args:
            progress: Is called with the share that is done.

        Raises:
            DataError: Line centres are of poses that the recording does not have.
            ScanError: No image shows a stripe, or no line centre gave a point.
            RobolaserError: A file or an image cannot be read.
        """
        waiting, done = iter(self.source.pieces), 0
        seen = np.zeros(len(self.scanner.dataset.poses), dtype=bool)
        self.counts.centres = self.counts.points = 0
        with ThreadPoolExecutor(cores(), thread_name_prefix="robolaser") as threads:
            while batch := list(islice(waiting, PIECES_AT_ONCE * cores())):
                for centres, piece in threads.map(self._piece, batch):
                    self.counts.centres += centres
                    self.counts.points += len(piece)
                    seen[piece["pose"]] = True
                    yield piece
                done += len(batch)
                if progress is not None:
                    progress("scanning", done / len(self.source.pieces))
        self.counts.poses = int(seen.sum())
        if self.counts.centres == 0:
            raise no_line_centres(self.source.what)
        if self.counts.points == 0:
            raise ScanError(
                f"For none of {self.counts.centres} line centres does the ray meet the laser plane in front of the"
                " camera. Check stripe_axis, and that calibration and recording belong to the same scanner."
            )

    def _piece(self, read: Callable[[], Stripes]) -> tuple[int, Vertices]:
        """How many line centres there are, and the points that they give."""
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
    moves = robot.jacobian(poses.q[None], points[None])[0][:, :3, list(robot.chain)]  # by each joint, (n, 3, j)
    return np.asarray(sigma * np.linalg.norm(np.linalg.norm(moves, axis=1), axis=1))
