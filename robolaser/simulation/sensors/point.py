"""A simulated laser tracker in the cell that sees reflectors on the flange."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.geometry.rigid_motion import apply
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import motion, named_parts, vector
from robolaser.parameters import Values
from robolaser.robot.postures import random_configurations
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor, nominal_points, seen_by_tracker
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

TRACKER_M = (2.5, -1.5, 1.2)  # position of the base, seen from the tracker
TILT_RAD = 0.02  # of the base against the tracker's level, at most
REFLECTORS_M = (0.08, 0.12)  # distance of the reflectors from the flange's axis, least and most
GROSS_M = (5e-3, 5e-2)  # reflectors are mixed up


@final
@dataclass(frozen=True)
class SimulatedTracker(SimulatedSensor):
    """A tracker that sees every reflector in every pose."""

    kind: ClassVar[str] = "point"
    own_noise: ClassVar[tuple[str, str]] = ("xyz", "point_m")

    names: tuple[str, ...]  # of the reflectors

    @classmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """A tracker some metres from the arm, and reflectors around the flange's axis."""
        rng, points = random.build, setup.points
        turn = rng.uniform(-np.pi, np.pi)
        tilt = rng.uniform(-TILT_RAD, TILT_RAD, 2)
        base = (*(np.array(TRACKER_M) + rng.uniform(-0.5, 0.5, 3)), *tilt, turn)
        truth = named_parts("base", base)
        names = tuple(map(str, range(points)))
        for i, name in enumerate(names):
            angle, radius = 2 * np.pi * i / points + rng.uniform(-0.3, 0.3), rng.uniform(*REFLECTORS_M)
            place = (radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.02, 0.08))
            truth |= named_parts(f"tool.{name}", place)
        return cls(truth, random_configurations(dataset.arm[0], len(dataset.poses), random.place), names)

    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """Every reflector, in the tracker's frame."""
        n = len(dataset.poses)
        rows = np.repeat(np.arange(n), len(self.names))
        tools = np.stack([vector(values, f"tool.{name}")[0] for name in self.names])
        points = Points(rows, self.names * n, xyz=np.zeros((len(rows), 3)))

        def seen(points: Points) -> Points:
            model = Model(replace(dataset, points=points), effects)
            perturb = model.perturb(values)
            T_world_flange = motion(values, "base")[0] @ model.flange(values, perturb)[0]
            there = apply(T_world_flange[rows], np.tile(tools, (n, 1)))
            return replace(points, xyz=nominal_points(there, perturb))

        return seen_by_tracker(dataset, points, seen)

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Points in any direction."""
        way = rng.normal(size=(len(rows), 3))
        far = rng.uniform(*GROSS_M, (len(rows), 1))
        xyz = dataset.points["xyz"].copy()
        xyz[rows] += far * way / np.linalg.norm(way, axis=1, keepdims=True)
        return replace(dataset, points=replace(dataset.points, xyz=xyz))
