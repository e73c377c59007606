"""A tracker in the cell that sees points on the flange."""

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.sensor_format import XYZ, SensorFormat
from robolaser.geometry.rigid_motion import carry, pose
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.sensors.placements import motion, places, places_by_name, six_names, six_of
from robolaser.model.sensors.sensor import Perturbation, Sensor, SensorParameters, Stage, Values
from robolaser.model.sensors.tracker_fit import base_and_tools, enough_of_each


@final
class Point(Sensor):
    """Measured points P_world = T_world_base T_base_flange tool, a tool point for each reflector."""

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="point",
        title="laser tracker",
        columns={"xyz": XYZ},
        task="the model predicts tracked points",
        named_points="tool",
        tracker=True,
    )
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.TARGET}

    @cached_property
    def parameters(self) -> SensorParameters:
        """T_world_base and the tool points."""
        tools = (f"tool.{name}.{part}" for name in self.names for part in "xyz")
        return SensorParameters(derived=(*six_names("base"), *tools))

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """The best of all, the middle angle within ±π/2."""
        rows = enough_of_each(self.dataset.points.number)
        measured = perturb(Stage.TARGET, self.dataset.points["xyz"][None])[:, rows]
        T = T_base_flange[:, self.dataset.points.pose[rows]]
        R, shift, tools = base_and_tools(measured, T, self.dataset.points.number[rows])
        return six_of(pose(R, shift), "base") | places_by_name(tools, "tool", self.names)

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured point less predicted point, in the world frame, (c, m, 3) [m]."""
        tools = places(values, "tool", self.names)
        T_world_flange = motion(values, "base")[:, None] @ T_base_flange
        seen = carry(T_world_flange, self.dataset.points.pose, tools[:, self.dataset.points.number])
        return self.known(values, T_base_flange, perturb) - seen

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The measured points, in the tracker's frame, (c or 1, m, 3) [m]."""
        return perturb(Stage.TARGET, self.dataset.points["xyz"][None])

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`point` [m], isotropic, each row's own."""
        m = len(self.dataset.points.number)
        return [ErrorSource("point", along_each_axis(m, 3), np.arange(m), stated=self.dataset.noise.point_m)]
