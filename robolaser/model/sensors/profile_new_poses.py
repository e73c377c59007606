"""Profiles of balls that a sensor would see at other poses."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Points
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.sensors.new_poses import NewPoses
from robolaser.model.sensors.placements import motion, places
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

ARC = np.radians(60.0)  # half the arc of a ball that a sensor sees
MOST_CUT = 0.75
"""Distance of a ball's middle from the profile's plane, over its radius, up to which the ball is seen well."""
ROWS = 24  # of a profile that would be seen


@final
class ProfileNewPoses(NewPoses):
    """Poses are good where the sensor's plane cuts a ball near its middle, within the range that was measured."""

    def __init__(self, sensor: Sensor, *, stands: bool) -> None:
        points = sensor.dataset.points
        self._sensor, self._stands = sensor, stands
        self._balls, self._ball = tuple(dict.fromkeys(points.names)), points.number

    def aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array]:
        """Balls go where balls were seen: a ball in the flange frame and in the base frame, once for each profile."""
        of_pose = self._sensor.dataset.points.pose
        _, first = np.unique(of_pose * len(self._balls) + self._ball, return_index=True)
        known = self._sensor.known(values, T_base_flange[None], Perturbation())
        assert known is not None  # balls are
        there = known[0, first]
        return apply(inverse(T_base_flange[of_pose[first]]), there), there

    def seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """A profile of the ball that is nearest to the sensor's plane, where points lie within the range measured."""
        balls = places(values, "ball", self._balls)[0]
        radii = np.array([self._sensor.dataset.radius_m[name] for name in self._balls])
        hand_eye = motion(values, "hand_eye")
        there = apply(T_base_flange[:, None], balls) if self._stands else balls
        T_base_sensor = hand_eye if self._stands else T_base_flange @ hand_eye
        there = apply(inverse(T_base_sensor)[:, None], there)
        measured = self._sensor.dataset.points["profile"]
        low, high = measured.min(axis=0), measured.max(axis=0)
        near = there - radii[:, None] * (0.0, 0.0, 1.0)
        inside = ((near[..., ::2] >= low) & (near[..., ::2] <= high)).all(axis=-1)
        beside = np.where(inside, np.abs(there[..., 1]) / radii, np.inf)
        nearest, poses = beside.argmin(axis=1), np.arange(len(T_base_flange))
        x, y, z = there[poses, nearest].T[..., None]
        radius, angle = np.sqrt(np.maximum(radii[nearest, None] ** 2 - y**2, 0.0)), np.linspace(-ARC, ARC, ROWS)
        profile = np.stack([x + radius * np.sin(angle), z - radius * np.cos(angle)], axis=-1)
        names = tuple(self._balls[ball] for ball in nearest.repeat(ROWS).tolist())
        points = Points(poses.repeat(ROWS), names, columns={"profile": profile.reshape(-1, 2)})
        return points, np.asarray(beside[poses, nearest] < MOST_CUT)
