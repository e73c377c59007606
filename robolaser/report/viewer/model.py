"""What is believed of a cell, nominal or calibrated: where arm, scanner and light stand, and where points lie."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.errors import ParameterMissing
from robolaser.geometry.rigid_motion import apply, rigid_fit
from robolaser.model.sensors.compiled_stripe import SCANNER
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.carry_over import carried_over, sight_of
from robolaser.scan.scanner_model import Sight
from robolaser.scan.sources import places_in_images

USUAL_DEPTH_M = 0.3  # of the work where the sheet is nowhere in front of the camera
FAN = 48  # places along the stripe


@final
@dataclass(frozen=True)
class Posture:
    """The cell at one pose, in the base frame.

    Attributes:
        joints: T_base_joint of the chain, base first, (k, 4, 4); none where flange poses were measured.
        flange: T_base_flange, (4, 4).
        camera: T_base_camera, (4, 4); None where there is no scanner.
        corners: Where the image's corners look at the working distance, (4, 3) [m].
        projector: Where the light comes from, (3,) [m].
        light: Where the sheet lies on the line of pixels that the stripe usually takes, (p, 3) [m].
        stripe: Where the stripe's middles of this pose lie, along it, (m, 3) [m].
    """

    joints: Array
    flange: Array
    camera: Array | None = None
    corners: Array | None = None
    projector: Array | None = None
    light: Array | None = None
    stripe: Array | None = None


@final
@dataclass(frozen=True)
class Belief:
    """A model of a cell.

    Attributes:
        name: "nominal" or "calibrated".
        dataset: What was measured, as this model has it.
        sight: What the scanner sees; None for other sensors.
        elsewhere: The same for other poses of the same cell.
        notes: What the user should know about it.
    """

    name: str
    dataset: Dataset
    sight: Sight | None
    elsewhere: Callable[[Dataset], Sight] | None
    notes: tuple[str, ...] = ()

    @cached_property
    def points(self) -> Array:
        """Where the measured points lie, (m, 3) [m]; NaN where the sheet does not show them."""
        points = self.dataset.points
        return np.empty((0, 3)) if self.sight is None or not len(points) else self.sight.in_base(points)

    @cached_property
    def target(self) -> Array:
        """Where the target's points lie, (m, 3) [m]: as given, or laid where they fit the measured ones best."""
        xyz = self.dataset.points.xyz
        if xyz is None or self.sight is None:
            return np.empty((0, 3))
        good = np.isfinite(self.points).all(axis=1)
        if self.dataset.placed or good.sum() < 3:
            return xyz
        return apply(rigid_fit(xyz[good], self.points[good]), xyz)

    @cached_property
    def across_px(self) -> float:
        """The pixel across the stripe at which it usually lies."""
        pixel, along_u = self.dataset.points.pixel, self.dataset.stripe_axis == "u"
        if pixel is not None and len(pixel):
            return float(np.median(pixel[:, 1 if along_u else 0]))
        assert self.sight is not None  # asked for with a scanner only
        return float(self.sight.values["v_0" if along_u else "u_0"][0])

    def at_pose(self, number: int) -> Posture:
        """The cell as it stood at a pose of the data set."""
        return self._posture(self.dataset, self.sight, number)

    def at(self, q: Array) -> Posture:
        """The cell with its joints elsewhere, (j,) [rad or m]."""
        poses = Poses(("here",), time_s=np.zeros(1), q=q[None])
        here = replace(self.dataset, poses=poses, points=Points(np.empty(0, np.int64), ()))
        return self._posture(here, None if self.elsewhere is None else self.elsewhere(here), 0)

    def _posture(self, dataset: Dataset, sight: Sight | None, number: int) -> Posture:
        robot, poses = dataset.robot, dataset.poses
        joints = np.empty((0, 4, 4))
        if robot is not None and poses.q is not None:
            q, placements = (poses.q[None], None) if sight is None else sight.arm
            shared = placements if placements is None or placements.shape[1] == 1 else placements[:, number, None]
            joints = robot.joint_frames(q[:, number, None], shared)[0, 0]
        if sight is None:
            return Posture(joints, dataset.flange()[number])
        return self._with_scanner(Posture(joints, sight.flange[number]), sight, number)

    def _with_scanner(self, posture: Posture, sight: Sight, number: int) -> Posture:
        """The same with camera and light."""
        T = sight.camera[number]
        width, height = self.dataset.image_px or (1, 1)
        along = np.linspace(0.0, (width if self.dataset.stripe_axis == "u" else height) - 1.0, FAN)
        line = [along, np.full(FAN, self.across_px)]
        pixel = np.column_stack(line if self.dataset.stripe_axis == "u" else line[::-1])
        light = sight.in_camera(Points(np.full(FAN, number), (), pixel=pixel))
        seen = light[np.isfinite(light).all(axis=1)]
        depth = float(np.median(seen[:, 2])) if len(seen) else USUAL_DEPTH_M
        ends = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]) - 0.5
        normal, offset = sight.sheet[number, :3], sight.sheet[number, 3]
        own = sight.dataset.points.pose == number
        stripe = self.points[own] if len(sight.dataset.points) else np.empty((0, 3))
        return replace(
            posture,
            camera=T,
            corners=apply(T, depth * self._directions(ends, sight)),
            projector=apply(T, np.array([offset / normal[0] if normal[0] else 0.0, 0.0, 0.0])),
            light=apply(T, seen),
            stripe=self._along_stripe(stripe, own),
        )

    def _directions(self, pixel: Array, sight: Sight) -> Array:
        """Viewing rays with z = 1 of some pixels, by the nominal lens without distortion, (p, 3)."""
        f, s_u, s_v, u_0, v_0 = (float(sight.values[name][0]) for name in ("f", "s_u", "s_v", "u_0", "v_0"))
        u, v = (pixel[:, 0] - u_0) * s_u / f, (pixel[:, 1] - v_0) * s_v / f
        x, y = (v, -u) if self.dataset.stripe_axis == "u" else (u, v)
        return np.stack([x, y, np.ones(len(pixel))], axis=-1)

    def _along_stripe(self, stripe: Array, own: Array) -> Array:
        pixel = self.dataset.points.pixel
        if pixel is None or not len(stripe):
            return np.empty((0, 3))
        order = np.argsort(pixel[own, 0 if self.dataset.stripe_axis == "u" else 1])
        ordered = stripe[order]
        return ordered[np.isfinite(ordered).all(axis=1)]


def nominal(dataset: Dataset) -> Belief:
    """The cell as dataset.toml has it.

    Raises:
        ParameterMissing: A stripe scanner lacks one of its fourteen.
    """
    if dataset.kind != "stripe":
        return Belief("nominal", dataset, None, None)
    missing = [name for name in SCANNER if name not in dataset.parameters]
    if missing:
        raise ParameterMissing(missing, dataset.kind)
    values = {name: np.array([dataset.parameters[name].nominal]) for name in SCANNER}
    return Belief("nominal", dataset, Sight(dataset, values), lambda here: Sight(here, values))


def calibrated(scanner: Calibrated, dataset: Dataset) -> Belief:
    """The cell as a calibration found it.

    Raises:
        ScannerDiffers: It is of another scanner.
    """
    fitted = scanner.fitted_to(dataset)
    sight, notes = carried_over(scanner, fitted, places_in_images(fitted, np.arange(len(fitted.poses))))
    return Belief("calibrated", fitted, sight, lambda here: sight_of(scanner, here), notes)
