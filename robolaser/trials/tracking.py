"""Random synthetic cells in which a tracker sees an arm."""

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import pose
from robolaser.model.sensors.placements import motion, vector
from robolaser.parameters import as_batch
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import random_configurations
from robolaser.trials.building import PAYLOAD_KG, Ranges, pause_times, velocities
from robolaser.trials.resampling import ReferenceCell
from robolaser.trials.synthetic.cell import TrackerCell
from robolaser.trials.synthetic.run import SyntheticRun
from robolaser.trials.world import World, rounded

REFLECTORS = ("A", "B", "C")
BASE_M = (2.5, -1.5, 1.2)  # from the tracker, some decimetres more or less


def build_tracked(source: Robot | ReferenceCell, ranges: Ranges, rng: np.random.Generator, *, moving: bool) -> World:
    """A tracker before an arm, which may be moving, or before the arm, the poses and the reflectors of a data set."""
    if isinstance(source, ReferenceCell):
        robot, q, qd, time = source.visits
    else:
        robot, n = source, int(rng.integers(ranges.poses[0], ranges.poses[1] + 1))
        q = random_configurations(robot, n, rng)
        time = pause_times(n, rng)
        qd = velocities(q, rng, moving=moving)
    flange = robot.forward(q)[:, :3, 3]
    radius = float(np.linalg.norm(flange - flange.mean(axis=0), axis=1).max())
    run = SyntheticRun(robot, q, qd, time, flange.mean(axis=0), radius, float(rng.uniform(*PAYLOAD_KG)))
    if isinstance(source, ReferenceCell) and source.is_tracked:
        cell, stated = _found(source, run), source.dataset.noise.point_m
    else:
        reflectors = {name: _reflector(i, rng) for i, name in enumerate(REFLECTORS)}
        turn = Rotation.from_euler("ZYX", [rng.uniform(-np.pi, np.pi), *rng.uniform(-0.02, 0.02, 2)])
        T_world_base = pose(turn.as_matrix(), np.array(BASE_M) + rng.uniform(-0.5, 0.5, 3))
        cell, stated = TrackerCell(run, T_world_base, reflectors), None
    noise = Noise(point_m=stated or rounded(rng.uniform(*ranges.point_m)))
    blank = Dataset(
        name="blind",
        robot=robot,
        poses=Poses(tuple(map(str, range(len(q)))), time_s=time, q=q, qd=qd),
        points=cell.seen(()),
        kind="point",
        noise=noise,
    )
    return World(cell, blank, noise)


def _found(source: ReferenceCell, run: SyntheticRun) -> TrackerCell:
    """Tracker and reflectors where a calibration found them."""
    values = as_batch(source.found)
    names = dict.fromkeys(source.dataset.points.names)
    return TrackerCell(run, motion(values, "base")[0], {name: vector(values, f"tool.{name}")[0] for name in names})


def _reflector(number: int, rng: np.random.Generator) -> Array:
    """Around the flange's axis, some centimetres in front of it."""
    angle = 2 * np.pi * number / len(REFLECTORS) + rng.uniform(-0.3, 0.3)
    radius = rng.uniform(0.06, 0.14)
    return np.array([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.02, 0.1)])
