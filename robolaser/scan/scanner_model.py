"""What a calibrated scanner sees: camera and laser plane at each pose, and the point that a pixel shows."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points
from robolaser.duals import Dual
from robolaser.geometry.rigid_motion import apply
from robolaser.model.effects.effect import Effect, Run, perturb_with
from robolaser.model.effects.run import Course
from robolaser.model.sensors.scanner_geometry import in_camera, mount
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

FARTHEST_M = 10.0  # from the camera: beyond, rays are nearly parallel to the laser plane


@final
@dataclass(frozen=True)
class ScannerModel:
    """A recording's poses as a calibrated scanner and its effects have them.

    Attributes:
        dataset: The recording, with the calibrated scanner and its arm.
        values: The fourteen parameters, (1,) each.
        effects: Those that perturb what passes, in their order.
        course: How far the run had come at each pose, where the recording does not count from its own beginning.
    """

    dataset: Dataset
    values: Values
    effects: tuple[Effect, ...] = ()
    course: Course | None = None

    def perturb(self, points: Points) -> Perturbation:
        """The effects as they act on some points of the recording."""
        return perturb_with(self.effects, Run(replace(self.dataset, points=points), self.course))

    @cached_property
    def at_poses(self) -> Points:
        """The principal point in every pose."""
        n = len(self.dataset.poses)
        centre = np.column_stack([self.values["u_0"], self.values["v_0"]])
        return Points(np.arange(n), (), pixel=np.repeat(centre, n, axis=0))

    @cached_property
    def arm(self) -> tuple[Array, Array]:
        """Joint angles and the joints' placements on the links before them, (1, n, j) and (1, n or 1, j, 4, 4)."""
        perturb, (robot, q) = self.perturb(self.at_poses), self.dataset.arm
        return perturb(Stage.JOINTS, q[None]), perturb(Stage.LINKS, robot.placements[None, None])

    @cached_property
    def flange(self) -> Array:
        """T_base_flange at each pose, (n, 4, 4)."""
        robot = self.dataset.robot
        T_base_flange = self.dataset.flange()[None] if robot is None else robot.forward(*self.arm)
        perturbed: Array = self.perturb(self.at_poses)(Stage.FLANGE, T_base_flange)[0]
        return perturbed

    @cached_property
    def camera(self) -> Array:
        """T_base_camera at each pose, (n, 4, 4)."""
        T: Array = self.flange @ mount(self.dataset, self.values, self.perturb(self.at_poses))[0]
        return T

    def in_camera(self, points: Points) -> Array:
        """Where the rays of some pixels meet the laser plane, in the camera frame, (m, 3) [m].

        NaN where the ray does not meet it in front of the camera, within FARTHEST_M.
        """
        return self._in_front(self._seen(points, points["pixel"]))

    def _seen(self, points: Points, pixel: Array) -> Array:
        seen: Array = in_camera(pixel[None], self.values, self.perturb(points), self.dataset.stripe_axis)[0]
        return seen

    def _in_front(self, seen: Array, of: Array | None = None) -> Array:
        in_front = (seen[:, 2] > 0) & (seen[:, 2] < FARTHEST_M)
        return np.where(in_front[:, None], seen if of is None else of, np.nan)

    def in_base(self, points: Points) -> Array:
        """The same in the base frame."""
        return apply(self.camera[points.pose], self.in_camera(points))

    def slope(self, points: Points) -> Array:
        """How far a point moves when its pixel moves across the stripe, (m,) [m/px]."""
        across = np.array([0.0, 1.0] if self.dataset.stripe_axis == "u" else [1.0, 0.0])
        pixel = Dual(points["pixel"], np.broadcast_to(across, (1, len(points), 2)), (0,))
        seen: Any = self._seen(points, cast("Array", pixel))
        return np.asarray(np.linalg.norm(self._in_front(seen.value, seen.slopes[0]), axis=-1))
