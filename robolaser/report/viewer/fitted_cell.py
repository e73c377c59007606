"""A cell of any sensor by a calibration: where arm and camera are, where points are known and where they were seen."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.errors import DataError
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.blocks.cell_frames import camera_of
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.report.model_scene import CellPoses
from robolaser.report.viewer.cell_model import CellFrames

DEPTH_M: Final = 0.3
"""How far the camera's view is drawn."""


@final
@dataclass(frozen=True)
class FittedCell:
    """A cell by a calibration.

    Attributes:
        model: Data and effects.
        x: The parameters that were found, (d,).
        name: What the viewer calls it.
        notes: What the user should know about it.
    """

    model: Model
    x: Array
    name: str = "calibrated"
    notes: tuple[str, ...] = ()

    @property
    def dataset(self) -> Dataset:
        """What was measured."""
        return self.model.dataset

    @cached_property
    def _poses(self) -> CellPoses:
        return CellPoses(self.model, self.x, np.arange(len(self.dataset.poses)))

    @property
    def target(self) -> Array:
        """Where points are known or were measured to be, (m, 3) [m]; none where rows are no points."""
        return self._poses.known if len(self.dataset.points) else np.empty((0, 3))

    @cached_property
    def points(self) -> Array:
        """Where the model has them, (m, 3) [m]."""
        if not len(self.target):
            return self.target
        shifts = self._poses.shifts(self.model.in_metres(self.x, self.model.residuals(self.x[None])[0]))
        return self.target if shifts is None else self.target + shifts

    @property
    def groups(self) -> tuple[str, ...]:
        """What of the sensor is drawn."""
        return () if self._poses.cameras is None else ("sensor",)

    def at_pose(self, number: int) -> CellFrames:
        """The cell at a pose of the data set."""
        q = self.dataset.poses.q
        return self._frames(number, self._poses.flanges[number], None if q is None else q[number])

    def at(self, q: Array) -> CellFrames:
        """The cell at other joint angles, (j,) [rad or m], with the effects as at the first pose."""
        values = self._poses.values
        moved = np.broadcast_to(q, (1, len(self.dataset.poses), len(q)))
        return self._frames(0, np.asarray(self.model.flange(values, q=moved))[0, 0], q)

    def _frames(self, number: int, flange: Array, q: Array | None) -> CellFrames:
        robot, cameras, joints = self.dataset.robot, self._poses.cameras, np.empty((0, 4, 4))
        if robot is not None and q is not None:
            perturb = self.model.perturb(self._poses.values)
            moved = np.broadcast_to(q, (1, len(self.dataset.poses), len(q)))
            placements = perturb(Stage.LINKS, robot.placements[None, None])
            shared = placements if placements.shape[1] == 1 else placements[:, number, None]
            joints = robot.joint_frames(perturb(Stage.JOINTS, moved)[:, number, None], shared)[0, 0]
        if cameras is None:
            return CellFrames(joints, flange)
        mounted = inverse(self._poses.flanges[number]) @ cameras[number]
        camera = flange @ mounted if self._poses.rides else cameras[number]
        return CellFrames(joints, flange, camera, apply(camera, self._view))

    @cached_property
    def _view(self) -> Array:
        """The corners of the image at some depth, in the camera's frame, (4, 3) [m]."""
        view = camera_of(self.model.blocks, self._poses.values, self.model.perturb(self._poses.values))
        width, height = self.dataset.image_px or (4, 3)
        ends = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]) - 0.5
        K = np.array([[width, 0.0, width / 2], [0.0, width, height / 2], [0.0, 0.0, 1.0]]) if view is None else view.K
        return DEPTH_M * np.linalg.solve(K, np.column_stack([ends, np.ones(len(ends))]).T).T


def fitted_cell(dataset: Dataset, effects: tuple[CandidateEffect, ...], numbers: Mapping[str, float]) -> FittedCell:
    """The cell of a data set by the numbers of a calibration, by name.

    Raises:
        DataError: The calibration lacks a number that the data set's model has: it is of another cell.
    """
    model = Model(dataset, effects)
    if missing := [name for name in model.parameters.names if name not in numbers]:
        raise DataError(
            f"The calibration has no {', '.join(missing[:4])}, which {dataset.name} needs: it is of another cell, or of"
            " other sessions. Name the calibration of this data set.",
            file="calibration.json",
        )
    return FittedCell(model, np.array([numbers[name] for name in model.parameters.names]))
