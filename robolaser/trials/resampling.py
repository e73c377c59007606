"""Random synthetic cells around a given data set: its arm, sensor, poses, target and noise; and those of trackers."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import rankdata

from robolaser.arrays import Array, Ints
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.path_velocities import known_velocities
from robolaser.data.stated_noise import Noise
from robolaser.errors import TrialError
from robolaser.geometry.rigid_motion import pose
from robolaser.model.noise.repeats import pixel_repeats
from robolaser.model.sensors import sensor_class
from robolaser.model.sensors.placements import motion, vector
from robolaser.model.sensors.point import Point
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import random_configurations
from robolaser.simulation.nominal import built
from robolaser.trials.building import IMAGE_PX, PAYLOAD_KG, WORKSHOP, Ranges, World, in_sight, pause_times, velocities
from robolaser.trials.synthetic.cell import ScannerCell, Target, TrackerCell
from robolaser.trials.synthetic.fault_model import SyntheticRun
from robolaser.trials.synthetic.scanner import ScannerOptics

OFF = 0.1  # of the workshop's deviations: difference of each world's scanner from the calibrated one
STEP_M = 5e-3  # least height of a step of the target
ROUNDS = 4
MINUTE_S = 60.0
REFLECTORS = ("A", "B", "C")
BASE_M = (2.5, -1.5, 1.2)  # from the tracker, within some decimetres


@final
@dataclass(frozen=True)
class ReferenceCell:
    """A data set to be imitated, and its calibration."""

    dataset: Dataset  # a placed stripe with joint angles, or a tracker's points of an arm whose joint angles are known
    found: Calibration

    @property
    def is_tracked(self) -> bool:
        """Whether a tracker measures the arm."""
        return self.dataset.kind == Point.format.kind

    @property
    def visits(self) -> tuple[Robot, Array, Array, Array]:
        """The arm, its joint angles and velocities, (n, j) each, and the times of the poses, (n,) [s].

        Unknown velocities are zero, and poses with a known order only are a minute apart.
        """
        (robot, q), poses = self.dataset.arm, self.dataset.poses
        known = known_velocities(self.dataset)
        timed = poses.time_s is not None and not self.dataset.time_is_order
        order = np.arange(len(q)) if poses.time_s is None else poses.time_s
        time = poses.time_s if timed else MINUTE_S * (rankdata(order, "ordinal") - 1.0)
        return robot, q, np.zeros(q.shape) if known is None else known, np.asarray(time)


def reference_of(dataset: Dataset, *, seed: int) -> ReferenceCell:
    """Calibrate the scanner of a data set, or its tracker and reflectors.

    Raises:
        TrialError: Another sensor or several, no joint angles, a target in an unknown pose, or sessions of a tracker.
        RobolaserError: It cannot be calibrated.
    """
    tracked = dataset.kind == Point.format.kind
    if not (tracked or sensor_class(dataset.kind).has_laser_plane()) or not len(dataset.points):
        raise _unsuitable(dataset.name, "it has no points of a stripe scanner or a tracker")
    if dataset.members or (tracked and dataset.sessions is not None):
        raise _unsuitable(dataset.name, "it has several sensors, or sessions of a tracker")
    if dataset.robot is None or dataset.poses.q is None:
        raise _unsuitable(dataset.name, "it has no robot with joint angles")
    if not tracked and not dataset.placed:
        raise _unsuitable(dataset.name, "the pose of its target is unknown")
    return ReferenceCell(dataset, calibrate(dataset, Plan(seed=seed)))


def _unsuitable(name: str, lacking: str) -> TrialError:
    return TrialError(
        f"A blind trial cannot be made like '{name}': {lacking}. It needs a robot with joint angles, "
        "and the points of a tracker, or of a stripe scanner and a placed target."
    )


def build_like(model: ReferenceCell, ranges: Ranges, rng: np.random.Generator) -> World:
    """A random cell around a user's poses and target.

    The scanner differs a little; target, columns and noise are those of the data. The ranges are of noise that
    the data set neither states nor shows by repeats.
    """
    dataset, points = model.dataset, model.dataset.points
    drawn = {item.name: item for item in model.found.model.parameters.items}
    most = {name: min(OFF * WORKSHOP.get(name, np.inf), 0.02 * (one.upper - one.lower)) for name, one in drawn.items()}
    truth = built(drawn, rng, {name: model.found.value(name) for name in drawn}, most, 0.0)
    eye = ScannerOptics(truth, dataset.bracket_quat, dataset.angles, dataset.stripe_axis)
    rows = np.sort(np.unique(points.place, return_index=True)[1])
    rows = rows[np.argsort(points.pose[rows], kind="stable")]
    target, level = stepped(points["xyz"][rows], dataset.flange()[:, :3, 3].mean(axis=0))
    along = target.inside(points["xyz"][rows])[:, :2]
    robot, q, qd, time = model.visits
    radius, payload_kg = float(np.linalg.norm(along, axis=1).max()) / 2, float(rng.uniform(*PAYLOAD_KG))
    run = SyntheticRun(robot, q, qd, time, target.middle, radius, payload_kg)
    at = points["pixel"][rows, 0 if dataset.stripe_axis == "u" else 1]
    cell = ScannerCell(run, eye, target, pose=points.pose[rows], at=at, level=level)
    repeats = pixel_repeats(dataset)
    read_px = dataset.noise.pixel_px or (repeats.sigma_px if repeats else None)
    pixel_px = read_px or ranges.noise("pixel_px", rng)
    noise = Noise(pixel_px=pixel_px, target_m=dataset.noise.target_m or ranges.noise("target_m", rng))
    blank = replace(dataset, name="blind", noise=noise, source="", licence="", board=None, folder=None, warnings=())
    return World(in_sight(cell, dataset.image_px or IMAGE_PX), blank, noise, max(1, len(points) // len(rows)))


def build_tracked(source: Robot | ReferenceCell, ranges: Ranges, rng: np.random.Generator, *, moving: bool) -> World:
    """A tracker and an arm, which may be moving, or the arm, poses and reflectors of a data set."""
    if isinstance(source, ReferenceCell):
        robot, q, qd, time = source.visits
    else:
        robot, n = source, ranges.count("poses", rng)
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
    noise = Noise(point_m=stated or ranges.noise("point_m", rng))
    poses = Poses(tuple(map(str, range(len(q)))), time_s=time, q=q, qd=qd)
    blank = Dataset(name="blind", robot=robot, poses=poses, points=cell.seen(()), kind="point", noise=noise)
    return World(cell, blank, noise)


def _found(source: ReferenceCell, run: SyntheticRun) -> TrackerCell:
    """Tracker and reflectors by a calibration."""
    values = source.found.values
    names = dict.fromkeys(source.dataset.points.names)
    return TrackerCell(run, motion(values, "base")[0], {name: vector(values, f"tool.{name}")[0] for name in names})


def _reflector(number: int, rng: np.random.Generator) -> Array:
    """A reflector beside the flange's axis, some centimetres in front of the flange."""
    angle = 2 * np.pi * number / len(REFLECTORS) + rng.uniform(-0.3, 0.3)
    radius = rng.uniform(0.06, 0.14)
    return np.array([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.02, 0.1)])


def stepped(xyz: Array, seen_from: Array) -> tuple[Target, Array]:
    """Find the parallel flat steps of points, (m, 3) [m], seen from any position above them, (3,) [m].

    Returns:
        The target, and the height of each point's step, (m,) [m].
    """
    middle = xyz.mean(axis=0)
    level_or_tilted = (np.eye(3), np.linalg.svd(xyz - middle, full_matrices=False)[2])
    axes, step, _ = min((_steps_facing(xyz - middle, start) for start in level_or_tilted), key=lambda fit: fit[2])
    up = np.sign(axes[2] @ (seen_from - middle))
    turned = axes * np.array([up * np.linalg.det(axes), 1.0, up])[:, None]
    return Target(middle, turned), _means(step, (xyz - middle) @ turned[2])


def _steps_facing(xyz: Array, axes: Array) -> tuple[Array, Ints, float]:
    """Axes near others along which points are on flat steps, the number of each point's step, and residuals.

    Steps are numbered from the lowest one.
    """
    for _ in range(ROUNDS):
        height = xyz @ axes[2]
        order = np.argsort(height)
        step = np.empty(len(height), dtype=np.int64)
        step[order] = np.cumsum(np.diff(height[order], prepend=height[order[0]]) > STEP_M)
        within = xyz - _means(step, xyz)
        axes = np.linalg.svd(within, full_matrices=False)[2]
    return axes, step, float(np.square(within @ axes[2]).sum())


def _means(step: Ints, values: Array) -> Array:
    """The mean of each step at its points, (m, ...)."""
    return np.array([values[step == i].mean(axis=0) for i in range(step.max() + 1)])[step]
