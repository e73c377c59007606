"""A simulated tracker in the cell that measures positions and orientations of bodies on the flange."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import exp_so3, from_quaternion, to_quaternion
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import SIX
from robolaser.model.sensors.pose import Pose
from robolaser.parameters import Values
from robolaser.robot.postures import random_configurations
from robolaser.simulation.sensors.point import GROSS_M, SimulatedTracker
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor, nominal_points, seen_by_tracker
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

GROSS_RAD = (0.02, 0.2)  # markers are mixed up


@final
@dataclass(frozen=True)
class SimulatedPoseTracker(SimulatedSensor):
    """A tracker that sees every body in every pose."""

    kind: ClassVar[str] = "pose"
    default_points: ClassVar[int] = 1

    names: tuple[str, ...]  # of the bodies

    @classmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """A tracker some metres from the arm, and bodies around the flange's axis, of any orientation."""
        truth = dict(SimulatedTracker.build(dataset, setup, random).truth)
        names, rng = tuple(map(str, range(setup.points))), random.build
        for name in names:
            turn = rng.uniform(-np.pi, np.pi), rng.uniform(-1.0, 1.0), rng.uniform(-np.pi, np.pi)
            truth |= {f"tool.{name}.{part}": float(angle) for part, angle in zip(SIX[3:], turn, strict=True)}
        return cls(truth, random_configurations(dataset.arm[0], len(dataset.poses), random.place), names)

    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """Every body, in the tracker's frame."""
        n = len(dataset.poses)
        rows = np.repeat(np.arange(n), len(self.names))
        level = {"quaternion": np.tile([0.0, 0.0, 0.0, 1.0], (len(rows), 1))}

        def seen(points: Points) -> Points:
            there = replace(dataset, points=points)
            model = Model(there, effects)
            perturb = model.perturb(values)
            T = Pose(there).predicted(values, model.flange(values, perturb), perturb)[0]
            turned = {"quaternion": to_quaternion(T[:, :3, :3])}
            return replace(points, xyz=nominal_points(T[:, :3, 3], perturb), columns=turned)

        points = Points(rows, self.names * n, xyz=np.zeros((len(rows), 3)), columns=level)
        return seen_by_tracker(dataset, points, seen)

    @classmethod
    def add_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Errors of position and rotation."""
        shift, turn = rng.normal(size=(2, len(points), 3))
        if noise.point_m is not None:
            points = replace(points, xyz=points["xyz"] + noise.point_m * shift)
        return points if noise.angle_rad is None else _turned(points, np.arange(len(points)), noise.angle_rad * turn)

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Bodies moved and turned in any direction."""
        shift, turn = rng.normal(size=(2, len(rows), 3))
        xyz = dataset.points["xyz"].copy()
        xyz[rows] += rng.uniform(*GROSS_M, (len(rows), 1)) * shift / np.linalg.norm(shift, axis=1, keepdims=True)
        turn *= rng.uniform(*GROSS_RAD, (len(rows), 1)) / np.linalg.norm(turn, axis=1, keepdims=True)
        return replace(dataset, points=_turned(replace(dataset.points, xyz=xyz), rows, turn))


def _turned(points: Points, rows: Ints, turn: Array) -> Points:
    """Points with some (k,) turned in the world frame, by (k, 3) [rad]."""
    quaternion = points["quaternion"].copy()
    quaternion[rows] = to_quaternion(exp_so3(turn) @ from_quaternion(quaternion[rows]))
    return replace(points, columns={**points.columns, "quaternion": quaternion})
