"""A tracker in the cell that measures positions and orientations of bodies on the flange."""

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import QUATERNION, XYZ, SensorFormat
from robolaser.geometry.hand_eye import robot_world_hand_eye
from robolaser.geometry.rigid_motion import from_quaternion, inverse, log_so3, pose
from robolaser.model.error_source import ErrorSource
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.sensors.placements import motion, six_names, six_of
from robolaser.model.sensors.sensor import Perturbation, Sensor, SensorParameters, Stage, Values
from robolaser.model.sensors.tracker_fit import enough_of_each


@final
class Pose(Sensor):
    """Measured T_world_body = T_world_base T_base_flange T_flange_body, the last for each body: A X = Z B.

    Motion capture, 6-D trackers, and cameras that see tags. Of a row's six numbers three are the measured position less
    the predicted one; the others are the turn vector from the predicted orientation to the measured one, both in the
    world frame.
    """

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="pose",
        title="6-D tracker",
        columns={"xyz": XYZ, "quaternion": QUATERNION},
        numbers=6,
        angles=3,
        task="the model predicts tracked bodies",
        named_points="tool",
        tracker=True,
    )
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.MOUNT, Stage.TARGET}

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._measured = dataset.points["xyz"][None]
        self._turned = from_quaternion(dataset.points["quaternion"])[None]

    @cached_property
    def parameters(self) -> SensorParameters:
        """T_world_base and T_flange_body of each body."""
        things = ("base", *(f"tool.{name}" for name in self.names))
        return SensorParameters(derived=tuple(name for thing in things for name in six_names(thing)), two_axes=True)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """In closed form, without start values."""
        rows = enough_of_each(self.dataset.points.number)
        T_world_body = pose(self._turned, perturb(Stage.TARGET, self._measured))[:, rows]
        T = T_base_flange[:, self.dataset.points.pose[rows]]
        of, each = self.dataset.points.number[rows], range(max(len(T), len(T_world_body)))
        found = [robot_world_hand_eye(T[i % len(T)], T_world_body[i % len(T_world_body)], of) for i in each]
        tools, T_base_world = (np.stack(every) for every in zip(*found, strict=True))
        start = six_of(inverse(T_base_world), "base")
        for number, name in enumerate(self.names):
            start |= six_of(tools[:, number], f"tool.{name}")
        return start

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured less predicted, in the world frame, (c, m, 6) [m, rad]."""
        T_world_body = self.predicted(values, T_base_flange, perturb)
        apart = self.known(values, T_base_flange, perturb) - T_world_body[..., :3, 3]
        turn = log_so3(self._turned @ np.swapaxes(T_world_body[..., :3, :3], -1, -2))
        return np.concatenate([apart, turn], axis=-1)

    def predicted(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """T_world_body of each row, (c, m, 4, 4): one bracket carries all bodies, the first of them is its camera."""
        T_world_flange = motion(values, "base")[:, None] @ T_base_flange
        tools = np.stack([motion(values, f"tool.{name}") for name in self.names], axis=1)
        if perturb.touches(Stage.MOUNT):
            T_world_flange = T_world_flange @ perturb(Stage.MOUNT, tools[:, :1])
            tools = inverse(tools[:, :1]) @ tools
            tools[:, 0] = np.eye(4)
        return T_world_flange[:, self.dataset.points.pose] @ tools[:, self.dataset.points.number]

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Of the position alone, (c, m, 3) [m]."""
        return residuals[..., :3]

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The measured positions, in the tracker's frame, (c or 1, m, 3) [m]."""
        return perturb(Stage.TARGET, self._measured)

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`point` [m] and `angle` [rad], both isotropic, each row's own."""
        m, noise, axes = len(self.dataset.points.number), self.dataset.noise, np.eye(6)
        place, turn = (np.broadcast_to(axes[:, part], (m, 6, 3)) for part in (slice(3), slice(3, 6)))
        return [
            ErrorSource("point", place, np.arange(m), stated=noise.point_m),
            ErrorSource("angle", turn, np.arange(m), "rad", stated=noise.angle_rad),
        ]

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """Each body as `tool_NAME`; the tracker as `tracker`."""
        bodies = {f"tool_{name}": motion(values, f"tool.{name}")[0] for name in self.names}
        tracker = {"tracker": inverse(motion(values, "base"))[0]}
        return InCell(bodies, tracker, published=(*tracker, *bodies))
