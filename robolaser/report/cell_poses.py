"""Positions of a cell's parts in each pose, by a fitted model: arm, sensor, light and points."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.blocks.cell_frames import in_cell
from robolaser.model.forward_model import Model
from robolaser.model.sensors.in_cell import is_static
from robolaser.model.sensors.placements import motion, vector
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

LIGHT_POINTS: Final = 16  # of the stripe, between which the laser plane is filled
DEPTH_M: Final = 0.3  # how far the camera's view is drawn
NOTHING: Final = np.empty((0, 3))


@final
@dataclass(frozen=True)
class CellFrames:
    """The frames of a cell at one pose, in the base frame."""

    joints: Array  # T_base_joint of the chain, base first, (k, 4, 4); none where flange poses were measured
    flange: Array  # T_base_flange, (4, 4)
    camera: Array | None = None  # T_base_camera, (4, 4); None where there is no camera
    corners: Array | None = None  # points at the corners of the image, (4, 3) [m]
    # the projector and points along the stripe, in order, (1 + p, 3) [m]; none without a laser
    light: Array = field(default_factory=lambda: NOTHING)


@final
@dataclass(frozen=True)
class CellPoses:
    """The cell in all poses (n), in the base frame [m]."""

    model: Model  # fitted
    x: Array  # its parameters
    name: str = "calibrated"  # its name in a viewer: "calibrated" or "nominal"
    is_measured: bool = True  # whether its points were measured; else they are possible points of a stripe

    @property
    def dataset(self) -> Dataset:
        """The measured data."""
        return self.model.dataset

    @cached_property
    def values(self) -> Values:
        """The parameters, (1,) each."""
        return self.model.parameters.values(self.x[None])

    @cached_property
    def _perturb(self) -> Perturbation:
        return self.model.perturb(self.values)

    @cached_property
    def flange(self) -> Array:
        """T_base_flange, (n, 4, 4)."""
        return np.broadcast_to(self.model.flange(self.values, self._perturb)[0], (len(self.dataset.poses), 4, 4))

    @property
    def rides(self) -> bool:
        """Is the camera on the flange, if there is one?"""
        return not is_static(self.model.blocks.sensor.dataset)

    @cached_property
    def camera(self) -> Array | None:
        """T_base_camera, (n, 4, 4); None where there is no camera."""
        mount = in_cell(self.model.blocks, self.values, self._perturb).mount
        if mount is not None:
            return np.asarray(self.flange @ mount[0])
        if "hand_eye.x" not in self.values:
            return None
        placed = motion(self.values, "hand_eye")
        return self.flange @ placed[0] if self.rides else np.broadcast_to(placed, self.flange.shape)

    def joint_frames(self, poses: Ints, q: Array | None = None) -> Array:
        """T_base_joint in some poses (p,), base first, (p, k, 4, 4); none where flange poses were measured.

        Joint values (n, j) may replace those read.
        """
        robot, q = self.dataset.robot, self.dataset.poses.q if q is None else q
        if robot is None or q is None:
            return np.empty((len(poses), 0, 4, 4))
        placements = self._perturb(Stage.LINKS, robot.placements[None, None])
        own = placements if placements.shape[1] == 1 else placements[:, poses]
        return np.asarray(robot.joint_frames(self._perturb(Stage.JOINTS, q[None])[:, poses], own)[0])

    @cached_property
    def tip(self) -> Array:
        """The camera, or the middle of the points on the flange, (n, 3)."""
        if self.camera is not None:
            return self.camera[:, :3, 3]
        tip = np.empty((len(self.dataset.poses), 3))
        for poses, values in self._sessions():
            names = dict.fromkeys(name.rpartition(".")[0] for name in values if name.startswith("tool."))
            tools = [vector(values, name)[0] for name in names] or [np.zeros(3)]
            tip[poses] = apply(self.flange[poses], np.mean(tools, axis=0)[None])
        return tip

    def line(self, poses: Ints) -> Array:
        """Base, joints and flange in some poses (p,), (p, 2 + joints, 3)."""
        flange = self.flange[poses, None, :3, 3]
        return np.concatenate([np.zeros(flange.shape), self.joint_frames(poses)[..., :3, 3], flange], axis=1)

    def light(self, poses: Ints) -> Array:
        """The first scanner's projector and its stripe's points in some poses (p,), (p, 1 + k, 3), if it has one."""
        scanners = [block for block in self.model.blocks if block.sensor.has_laser_plane()]
        if not scanners or self.camera is None or self._known is None:
            return np.empty((len(poses), 0, 3))
        of_first = [block for block in scanners if block.name == scanners[0].name]
        rows = np.concatenate([block.rows for block in of_first])
        seen, of_pose = self._predicted[rows], self.dataset.points.pose[rows]
        light = np.full((len(poses), 1 + LIGHT_POINTS, 3), np.nan)
        light[:, 0] = apply(self.camera[poses], np.array([[of_first[0].values(self.values)["b"][0], 0.0, 0.0]]))
        for i, pose in enumerate(poses):
            stripe = seen[of_pose == pose]
            stripe = stripe[np.isfinite(stripe).all(axis=1)]
            if len(stripe):
                along = np.linalg.svd(stripe - stripe.mean(axis=0), full_matrices=False)[2][0]
                order = np.argsort(stripe @ along)
                light[i, 1:] = stripe[order[np.linspace(0, len(order) - 1, LIGHT_POINTS).round().astype(int)]]
        return light

    @cached_property
    def _known(self) -> Array | None:
        """Known or measured points of all rows, (m, 3), in the base or a tracker's frame; None: no points."""
        known = self.model.blocks.known(self.values, self.model.flange(self.values, self._perturb), self._perturb)
        return None if known is None else known[0]

    @cached_property
    def known(self) -> Array:
        """The same in the base frame; none where rows are no points."""
        return np.empty((0, 3)) if self._known is None else self._in_base(self._known)

    def across_view(self, errors_m: Array) -> Bools:
        """Rows that locate a point only across the view, along image u and v, as a camera's do, (m,)."""
        of = self.dataset.sensor_of_row
        return ~np.isin(of, of[(errors_m[:, 2:] != 0.0).any(axis=1)])

    def shifts(self, errors_m: Array) -> Array | None:
        """Predicted less known or measured points, (m, 3); from errors in the sensor's own frame."""
        known, across = self._known, self.across_view(errors_m)
        if known is None or not len(self.known) or (across.any() and self.camera is None):
            return None
        moved = np.zeros(self.known.shape) if across.all() else self._in_base(known - errors_m) - self.known
        if self.camera is not None and across.any():
            R = self.camera[self.dataset.points.pose[across], :3, :3]
            u, v = -errors_m[across, :2].T
            moved[across] = np.einsum(
                "mij,mj->mi", R, np.stack([*((v, -u) if self._is_turned else (u, v)), 0 * u], axis=1)
            )
        return moved

    def misses(self, errors_m: Array) -> Array | None:
        """From each row's pixel to the predicted one, (m, 2) [px]; without the slope of the distortion."""
        view = in_cell(self.model.blocks, self.values, self._perturb).camera
        shifts, across = self.shifts(errors_m), self.across_view(errors_m)
        if view is None or shifts is None or self.camera is None:
            return None
        T_camera_base = inverse(self.camera)[self.dataset.points.pose]
        known, seen = (apply(T_camera_base, points) for points in (self.known, self.known + shifts))
        slopes: Array = known[:, :2] / known[:, 2:] - seen[:, :2] / seen[:, 2:]
        if self._is_turned:
            slopes = np.stack([-slopes[:, 1], slopes[:, 0]], axis=1)
        slopes[across] = -errors_m[across, :2] / known[across, 2:]
        return slopes @ view.K[:2, :2].T

    @property
    def _is_turned(self) -> bool:
        """Does the camera's frame have x along image v, as for a scanner whose stripe moves along u?"""
        return self.model.blocks.has_laser_plane and self.dataset.stripe_axis == "u"

    @property
    def groups(self) -> tuple[str, ...]:
        """The parts of the sensor that a viewer draws."""
        return (*("sensor",) * (self.camera is not None), *("light",) * self.model.blocks.has_laser_plane)

    @cached_property
    def target(self) -> Array:
        """Known or measured points, (m, 3); none where rows are no points."""
        return self.known if self.is_measured else NOTHING

    @cached_property
    def points(self) -> Array:
        """The predicted points, (m, 3)."""
        return self._predicted if len(self.target) else self.target

    @cached_property
    def _predicted(self) -> Array:
        shifts = self.shifts(self.model.in_metres(self.x, self.model.residuals(self.x[None])[0]))
        return self.known if shifts is None else self.known + shifts

    def at_pose(self, number: int) -> CellFrames:
        """The cell at a pose of the data set."""
        poses = np.array([number])
        joints, light = self.joint_frames(poses)[0], self.light(poses)[0]
        frames = CellFrames(joints, self.flange[number], light=light[np.isfinite(light).all(axis=1)])
        if self.camera is None:
            return frames
        return replace(frames, camera=self.camera[number], corners=apply(self.camera[number], self._view))

    def at(self, q: Array) -> CellFrames:
        """The cell at other joint angles, (j,) [rad or m], with the effects, and the light, as at the first pose."""
        moved = np.broadcast_to(q, (len(self.dataset.poses), len(q)))
        joints = self.joint_frames(np.array([0]), moved)[0]
        flange, first = np.asarray(self.model.flange(self.values, q=moved[None]))[0, 0], self.at_pose(0)
        if first.camera is None or first.corners is None or not self.rides:
            return replace(first, joints=joints, flange=flange)
        by = flange @ inverse(first.flange)
        return CellFrames(joints, flange, by @ first.camera, apply(by, first.corners), apply(by, first.light))

    @cached_property
    def _view(self) -> Array:
        """The corners of the image at some depth, in the camera's frame, (4, 3) [m]."""
        view = in_cell(self.model.blocks, self.values, self._perturb).camera
        width, height = self.dataset.image_px or (4, 3)
        ends = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]) - 0.5
        K = np.array([[width, 0.0, width / 2], [0.0, width, height / 2], [0.0, 0.0, 1.0]]) if view is None else view.K
        corners: Array = DEPTH_M * np.linalg.solve(K, np.column_stack([ends, np.ones(len(ends))]).T).T
        return corners[:, [1, 0, 2]] * [1.0, -1.0, 1.0] if self._is_turned else corners

    def _sessions(self) -> Iterator[tuple[Bools, Values]]:
        """The poses of each session, (n,), and its values by their names without sessions."""
        sessions, of_pose = self.dataset.sessions, self.dataset.poses.session
        if sessions is None or of_pose is None:
            yield np.ones(len(self.dataset.poses), dtype=bool), self.values
            return
        number = self.dataset.session_of_pose
        for one in np.unique(number):
            yield number == one, sessions.values_in(self.values, sessions.names[one])

    def _in_base(self, points: Array) -> Array:
        """Points (m, 3) of rows in the base frame, from a tracker's frame."""
        placed = points.copy()
        for poses, values in self._sessions():
            rows = poses[self.dataset.points.pose]
            if "base.x" in values:
                placed[rows] = apply(inverse(motion(values, "base")[0]), points[rows])
        return placed
