"""A laser profile sensor that measures balls of known radius."""

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import SensorFormat
from robolaser.data.subsampling import evenly
from robolaser.geometry.rigid_motion import carry, common_length, inverse, pose
from robolaser.model.error_source import ErrorSource
from robolaser.model.sensors.in_cell import InCell
from robolaser.model.sensors.mounting import Mounting, stands
from robolaser.model.sensors.new_poses import NewPoses
from robolaser.model.sensors.placements import motion, places, places_by_name, six_names, six_of
from robolaser.model.sensors.profile_new_poses import ProfileNewPoses
from robolaser.model.sensors.profile_start import circles, sensor_and_balls
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.sensors.sensor_parameters import SensorParameters
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

ENOUGH_PROFILES = 600  # profiles that start values are found from


@final
class Profile(Sensor):
    """Points (x, 0, z) of a profile lie on the ball: their distance from its centre is its radius.

    That distance less the radius is a row's one number. An isotropic error of a point moves it by the part of the
    ball's normal that lies in the profile's plane: where the plane cuts the ball near its rim, rows weigh more. So the
    fit that weighs rows by their noise is that of greatest likelihood, to first order in the noise over the radius.
    """

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="profile",
        title="profile sensor",
        columns={"profile": ("x_m", "z_m")},
        absent={"y_m": "a profile lies in the sensor's plane y = 0"},
        numbers=1,
        options=Mounting,
        many_rows=True,
        balls=True,
        task="the model puts profiles on balls",
        named_points="ball",
    )
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.MOUNT, Stage.TARGET}

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._measured = np.insert(dataset.points["profile"], 1, 0.0, axis=1)[None]
        self._balls = tuple(dict.fromkeys(dataset.points.names))
        self._ball = dataset.points.number
        self._radius = np.array([dataset.radius_m[name] for name in self._balls])[self._ball]
        self._stands = stands(dataset)

    @cached_property
    def parameters(self) -> SensorParameters:
        """The sensor's place on the flange or in the cell, and the balls at the other end."""
        balls = (f"ball.{name}.{part}" for name in self._balls for part in "xyz")
        return SensorParameters(derived=(*six_names("hand_eye"), *balls), two_axes=True)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """From the circles in which the sensor's plane cuts the balls."""
        seen = perturb(Stage.TARGET, self._measured)
        of_pose = self.dataset.points.pose
        _, first, profile = np.unique(of_pose * len(self._balls) + self._ball, return_index=True, return_inverse=True)
        each = range(common_length(seen, T_base_flange))
        found = []
        for candidate in each:
            centre, radius, enough = circles(seen[candidate % len(seen)][:, ::2], profile.reshape(-1))
            some = np.flatnonzero(enough)
            some = some[evenly(len(some), ENOUGH_PROFILES)]
            beside = np.sqrt(np.maximum(self._radius[first[some]] ** 2 - radius[some] ** 2, 0.0))
            T = T_base_flange[candidate % len(T_base_flange)][of_pose[first[some]]]
            T = T if self._stands else inverse(T)
            found.append(sensor_and_balls(centre[some], beside, T[None], self._ball[first[some]]))
        R, shift, balls = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return six_of(inverse(pose(R, shift)), "hand_eye") | places_by_name(balls, "ball", self._balls)

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Distance of each point from its ball's surface, positive outside, (c, m, 1) [m]."""
        apart = self.in_base(values, T_base_flange, perturb) - self.known(values, T_base_flange, perturb)
        off: Array = np.linalg.norm(apart, axis=-1) - self._radius
        return off[..., None]

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Along the ball's normals in the base frame, towards its middle, (c, m, 3) [m]."""
        return -residuals * self._normals(values, T_base_flange, perturb)

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The points of the profiles, in the base frame, (c, m, 3) [m]."""
        T_base_sensor = self._sensor_in_base(values, T_base_flange, perturb)
        return carry(T_base_sensor, self.dataset.points.pose, perturb(Stage.TARGET, self._measured))

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The middles of the balls, in the base frame, (c, m, 3) [m]."""
        balls = places(values, "ball", self._balls)[:, self._ball]
        return carry(T_base_flange, self.dataset.points.pose, balls) if self._stands else balls

    def _mount(self, values: Values, perturb: Perturbation) -> Array:
        return perturb(Stage.MOUNT, motion(values, "hand_eye")[:, None])

    def _normals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The ball's normal at each point, in the base frame, (c, m, 3)."""
        apart = self.in_base(values, T_base_flange, perturb) - self.known(values, T_base_flange, perturb)
        normals: Array = apart / np.linalg.norm(apart, axis=-1, keepdims=True)
        return normals

    def _sensor_in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """T_base_sensor, (c, n or 1, 4, 4)."""
        return motion(values, "hand_eye")[:, None] if self._stands else T_base_flange @ self._mount(values, perturb)

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`point` [m], alike along x and z of the sensor, each row's own."""
        normals = self._normals(values, T_base_flange, perturb)[0]
        axes = self._sensor_in_base(values, T_base_flange, perturb)[0, :, :3, :3:2]
        effect = normals[:, None] @ (axes if self._stands else axes[self.dataset.points.pose])
        return [ErrorSource("point", effect, np.arange(len(effect)), stated=self.dataset.noise.point_m)]

    @property
    def new_poses(self) -> NewPoses:
        """Profiles of the balls."""
        return ProfileNewPoses(self, stands=self._stands)

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """The sensor as `profile_sensor`, as it is at the first pose; balls on the flange as `ball_NAME`."""
        if not self._stands:
            mount = self._mount(values, perturb)
            sensor = {"profile_sensor": mount[0, 0]}
            return InCell(sensor, published=sensor, mount=mount)
        sensor = {"profile_sensor": motion(values, "hand_eye")[0]}
        middles = zip(self._balls, places(values, "ball", self._balls)[0], strict=True)
        balls = {f"ball_{name}": pose(np.eye(3), middle) for name, middle in middles}
        return InCell(balls, sensor, published=sensor)
