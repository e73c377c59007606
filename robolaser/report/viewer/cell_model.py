"""A model of a cell, nominal or calibrated: where arm, scanner and laser plane are, and where its points lie."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.errors import DataError
from robolaser.geometry.camera import metric, rays
from robolaser.geometry.rigid_motion import apply, rigid_fit
from robolaser.model.sensors import sensor_class
from robolaser.model.sensors.stripe import SCANNER
from robolaser.report.cell_poses import CellFrames
from robolaser.scan.calibrated import Calibrated
from robolaser.scan.carry_over import carried_over, scanner_in
from robolaser.scan.scanner_model import ScannerModel
from robolaser.scan.sources import points_in_images

USUAL_DEPTH_M = 0.3  # of the work where the laser plane is nowhere in front of the camera
FAN = 48  # points along the stripe


@final
@dataclass(frozen=True)
class CellModel:
    """A model of a cell.

    Attributes:
        name: "nominal" or "calibrated".
        dataset: What was measured, as this model has it.
        scanner: Geometry of its scanner; None for other sensors.
        elsewhere: The same at other poses of the cell.
        notes: What the user should know about it.
    """

    name: str
    dataset: Dataset
    scanner: ScannerModel | None
    elsewhere: Callable[[Dataset], ScannerModel] | None
    notes: tuple[str, ...] = ()

    @property
    def groups(self) -> tuple[str, ...]:
        """What of the sensor is drawn."""
        return () if self.scanner is None else ("sensor", "light")

    @cached_property
    def points(self) -> Array:
        """The stripe's points, (m, 3) [m]; NaN where rays miss the laser plane, and for what other sensors saw."""
        points = self.dataset.points
        if self.scanner is None or not len(points):
            return np.empty((0, 3))
        seen = self.scanner.in_base(points)
        for sensor in self.dataset.sensors:
            if not sensor_class(sensor.data.kind).has_laser_plane():
                seen[sensor.rows] = np.nan
        return seen

    @cached_property
    def target(self) -> Array:
        """The target's points, (m, 3) [m]: as given, or moved to fit the measured ones of each session best."""
        xyz = self.dataset.points.xyz
        if xyz is None or self.scanner is None:
            return np.empty((0, 3))
        good = np.isfinite(self.points).all(axis=1)
        if self.dataset.placed:
            return xyz
        target, session = xyz.copy(), self.dataset.session_of_pose[self.dataset.points.pose]
        for here in (session == number for number in np.unique(session)):
            if (seen := here & good).sum() >= 3:
                target[here] = apply(rigid_fit(xyz[seen], self.points[seen]), xyz[here])
        return target

    @cached_property
    def across_px(self) -> float:
        """The median pixel coordinate across the stripe."""
        pixel, along_u = self.dataset.points.pixel, self.dataset.stripe_axis == "u"
        if pixel is not None and len(pixel):
            return float(np.median(pixel[:, 1 if along_u else 0]))
        assert self.scanner is not None  # only scanners are drawn with a stripe
        return float(self.scanner.values["v_0" if along_u else "u_0"][0])

    def at_pose(self, number: int) -> CellFrames:
        """The cell at a pose of the data set."""
        return self._frames(self.dataset, self.scanner, number)

    def at(self, q: Array) -> CellFrames:
        """The cell at other joint angles, (j,) [rad or m]."""
        poses = Poses(("here",), time_s=np.zeros(1), q=q[None])
        here = replace(self.dataset, poses=poses, points=Points(np.empty(0, np.int64), ()))
        return self._frames(here, None if self.elsewhere is None else self.elsewhere(here), 0)

    def _frames(self, dataset: Dataset, scanner: ScannerModel | None, number: int) -> CellFrames:
        robot, poses = dataset.robot, dataset.poses
        joints = np.empty((0, 4, 4))
        if robot is not None and poses.q is not None:
            q, placements = (poses.q[None], None) if scanner is None else scanner.arm
            shared = placements if placements is None or placements.shape[1] == 1 else placements[:, number, None]
            joints = robot.joint_frames(q[:, number, None], shared)[0, 0]
        if scanner is None:
            return CellFrames(joints, dataset.flange()[number])
        return self._with_scanner(CellFrames(joints, scanner.flange[number]), scanner, number)

    def _with_scanner(self, frames: CellFrames, scanner: ScannerModel, number: int) -> CellFrames:
        """The same with camera and laser plane."""
        T = scanner.camera[number]
        width, height = self.dataset.image_px or (1, 1)
        along = np.linspace(0.0, (width if self.dataset.stripe_axis == "u" else height) - 1.0, FAN)
        line = [along, np.full(FAN, self.across_px)]
        pixel = np.column_stack(line if self.dataset.stripe_axis == "u" else line[::-1])
        light = scanner.in_camera(Points(np.full(FAN, number), (), pixel=pixel))
        seen = light[np.isfinite(light).all(axis=1)]
        depth = float(np.median(seen[:, 2])) if len(seen) else USUAL_DEPTH_M
        ends = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]) - 0.5
        to_ends = rays(metric(ends[None], scanner.values), scanner.values["f"], self.dataset.stripe_axis)[0]
        normal, offset = scanner.laser_plane[number, :3], scanner.laser_plane[number, 3]
        own = scanner.dataset.points.pose == number
        stripe = self.points[own] if len(scanner.dataset.points) else np.empty((0, 3))
        return replace(
            frames,
            camera=T,
            corners=apply(T, depth * to_ends / to_ends[:, 2:]),
            projector=apply(T, np.array([offset / normal[0] if normal[0] else 0.0, 0.0, 0.0])),
            light=apply(T, seen),
            stripe=self._along_stripe(stripe, own),
        )

    def _along_stripe(self, stripe: Array, own: Array) -> Array:
        pixel = self.dataset.points.pixel
        if pixel is None or not len(stripe):
            return np.empty((0, 3))
        order = np.argsort(pixel[own, 0 if self.dataset.stripe_axis == "u" else 1])
        ordered = stripe[order]
        return ordered[np.isfinite(ordered).all(axis=1)]


def has_nominal(dataset: Dataset) -> bool:
    """Whether dataset.toml gives all nominal values that drawing the cell takes."""
    return not (sensor_class(dataset.kind).has_laser_plane() and _not_given(dataset))


def _not_given(dataset: Dataset) -> list[str]:
    return [name for name in SCANNER if name not in dataset.parameters]


def nominal(dataset: Dataset) -> CellModel:
    """The cell by the nominal values of dataset.toml.

    Raises:
        DataError: A stripe scanner lacks one of its fourteen parameters.
    """
    if not sensor_class(dataset.kind).has_laser_plane():
        return CellModel("nominal", dataset, None, None)
    if missing := _not_given(dataset):
        raise DataError(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: a {dataset.kind} sensor needs "
            "{ nominal, lower, upper } for each. Or name a calibration beside it:"
            " `robolaser view DATASET CALIBRATION`.",
            file="dataset.toml",
            column="parameters",
        )
    values = {name: np.array([dataset.parameters[name].nominal]) for name in SCANNER}
    return CellModel("nominal", dataset, ScannerModel(dataset, values), lambda here: ScannerModel(here, values))


def calibrated(found: Calibrated, dataset: Dataset) -> CellModel:
    """The cell by a calibration.

    Raises:
        ScanError: It is of another scanner.
    """
    fitted = found.fitted_to(dataset)
    scanner, notes = carried_over(found, fitted, points_in_images(fitted, np.arange(len(fitted.poses))))
    return CellModel("calibrated", fitted, scanner, lambda here: scanner_in(found, here), notes)
