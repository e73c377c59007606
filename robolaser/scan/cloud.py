"""From the stripes of a recording to points in the base frame, piece by piece on all cores.

`std` of a point is the root-mean-square distance by which its noise moves it: the line centre's standard deviation
across the stripe, propagated through ray and laser plane, and the noise of the joints, propagated through the arm. The
latter is the calibration's estimate: the readings' noise, and whatever moved single poses unexplained. Where
that is much, points scatter less against their neighbours. Errors of the calibration that all points share are not in
it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import islice
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Progress
from robolaser.compiled import Loops, cores, share_out
from robolaser.data.stripe_file import STRIPE, Stripes
from robolaser.errors import ScanError
from robolaser.geometry.rigid_motion import apply
from robolaser.model.effects.effect import Run
from robolaser.model.stages import Stage
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.joint_sensitivity import joint_sensitivity
from robolaser.scan.ply import VERTEX, Vertices
from robolaser.scan.scanner_model import FARTHEST_M, ScannerModel
from robolaser.scan.sources import Source, as_points, check_poses, no_line_centres

PIECES_AT_ONCE = 32  # for each core, before they are handed on in order
_LOOPS = Loops("robolaser.scan.cloud_loops", pays_after=3_000_000)  # points
CAMERA = ("u_0", "v_0", "s_u", "s_v", "k", "f")


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
        while batch := list(islice(waiting, PIECES_AT_ONCE * cores())):
            found: dict[int, tuple[int, Vertices]] = {}
            share_out(partial(self._put, found, i, read) for i, read in enumerate(batch))
            for i in range(len(batch)):
                centres, piece = found[i]
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

    def _put(self, found: dict[int, tuple[int, Vertices]], place: int, read: Callable[[], Stripes]) -> None:
        stripes = read()
        check_poses(stripes, self.scanner.dataset)
        whole = self.source.points is not None or self._terms is None
        loops = None if whole else _LOOPS.after(len(stripes))
        found[place] = len(stripes), self._compiled(stripes, loops) if loops else self._in_numpy(stripes)

    @cached_property
    def _terms(self) -> tuple[Array, Array] | None:
        """`lens` and `light` of the compiled loop; None where it lacks a term for an effect on single points."""
        run = Run(self.scanner.dataset)
        pointwise = [one for one in self.scanner.effects if one.stage in (Stage.PIXELS, Stage.IMAGE, Stage.POINTS)]
        terms = [(effect.stage, effect.compiled_terms(run)) for effect in pointwise]
        if any(term is None for _, term in terms):
            return None
        lens, light = ([term for at, term in terms if at is stage] for stage in (Stage.IMAGE, Stage.POINTS))
        return np.array(lens, dtype=np.float64).reshape(-1, 3), np.array(light, dtype=np.float64).reshape(-1, 4)

    def _compiled(self, stripes: Stripes, loops: Any) -> Vertices:
        assert self._terms is not None  # else it would be done in NumPy
        n, stripes = len(stripes), np.ascontiguousarray(stripes)
        out = np.empty(n, VERTEX)
        count = loops.vertices(
            stripes.view("<f4").reshape(n, STRIPE.itemsize // 4),
            stripes.view("<u4").reshape(n, STRIPE.itemsize // 4),
            np.array([self.scanner.values[name][0] for name in CAMERA]),
            self.scanner.dataset.stripe_axis == "u",
            self.scanner.laser_plane,
            self.scanner.camera,
            self.arm,
            *self._terms,
            FARTHEST_M,
            out.view("<f4").reshape(n, VERTEX.itemsize // 4),
            out.view("<u4").reshape(n, VERTEX.itemsize // 4),
        )
        return out[:count]

    def _in_numpy(self, stripes: Stripes) -> Vertices:
        points = self.source.points or as_points(stripes)
        places = self.scanner.in_base(points)
        across = stripes["std"] * self.scanner.slope(points)
        out = np.empty(len(stripes), VERTEX)
        out["x"], out["y"], out["z"] = places.T
        out["std"] = np.hypot(across, self.arm[points.pose])
        out["pose"], out["intensity"] = stripes["pose"], stripes["intensity"]
        return out[np.isfinite(places).all(axis=1)]


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
    arms = joint_sensitivity(robot, poses.q, apply(scanner.camera, seen))
    return np.asarray(sigma * np.linalg.norm(arms, axis=1))
