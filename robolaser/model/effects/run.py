"""A run as effects see it: poses, points, and quantities derived from them, computed once."""

import hashlib
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Annotated, final

import numpy as np
from msgspec import Meta

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.path_velocities import known_velocities
from robolaser.model.blocks.block import Block, blocks_of
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.blocks.start import parameters_of
from robolaser.model.effects.gravity_load import Loads
from robolaser.model.effects.target_plane import TargetPlane, plane_of, surface_tilt
from robolaser.model.sensors import fitted_lens, parts_with_lens
from robolaser.model.sensors.tracker_fit import base_and_tools
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values
from robolaser.robot.kinematics import DOWN, Robot

RUN = "_run"
PAUSE = 0.01  # between sessions, in shares of one


@final
@dataclass(frozen=True)
class Course:
    """Progress of a run at each pose."""

    progress: Array  # share of the run that had passed, (n,), from 0 to 1
    # temperature above the lowest over the largest such rise, (n,); None where it is unknown or constant
    rise: Array | None
    by_thermometer: bool  # whether it is from temperatures of this run


@final
@dataclass(frozen=True, eq=False)
class Run:
    """A data set as effects see it. Slow quantities are computed when first needed, and cached.

    Data that the data set lacks must not be read: `Effect.missing` names them.
    """

    dataset: Dataset  # what was measured
    course: Course | None = None  # its progress, where that does not start at zero

    @cached_property
    def untouched(self) -> dict[Hashable, Bools]:
        """Rows of sensors that cannot have an effect at a location, (m,) each, as far as requested."""
        return {}

    @property
    def poses(self) -> Poses:
        """The poses of the arm."""
        return self.dataset.poses

    @property
    def points(self) -> Points:
        """The points seen."""
        return self.dataset.points

    @property
    def robot(self) -> Robot:
        """The nominal arm."""
        return self.dataset.arm[0]

    @property
    def q(self) -> Array:
        """Joint values as read, (n, j) [rad or m]."""
        return self.dataset.arm[1]

    @property
    def qd(self) -> Array:
        """Velocities at the exposures, (n, j), see `Poses.qd`."""
        qd = known_velocities(self.dataset)
        assert qd is not None  # effects that read them need velocities
        return qd

    @property
    def time_s(self) -> Array:
        """Times of the poses, (n,) [s]."""
        assert self.poses.time_s is not None  # effects that read them need the order
        return self.poses.time_s

    @cached_property
    def across_stripe(self) -> Array:
        """The direction across each row's stripe in its image, unit vectors (m, 2); (1, 2) for all rows alike."""
        axes = [sensor.data.stripe_axis for sensor in self.dataset.sensors]
        across = np.array([[0.0, 1.0] if axis == "u" else [1.0, 0.0] for axis in axes])
        return across if len(axes) == 1 else across[self.dataset.sensor_of_row]

    @cached_property
    def paths(self) -> tuple[Ints, ...]:
        """Numbers of the poses as they followed one another, of each session by itself, (k,) each."""
        assert self.poses.time_s is not None  # effects that read them need the order
        return self.dataset.paths

    @cached_property
    def progress(self) -> Array:
        """Share of its session that had passed at each pose, (n,), from 0 to 1: of its time, or else of its poses."""
        if self.course is not None:
            return self.course.progress
        if (places := self.dataset.in_whole()) is not None:
            return self.reference.progress[places]
        progress, time_s = np.empty(len(self.poses)), None if self.dataset.time_is_order else self.poses.time_s
        for path in self.paths:
            passed = np.arange(float(len(path))) if time_s is None else time_s[path] - time_s[path].min()
            duration = passed.max(initial=0.0)
            progress[path] = passed / duration if duration > 0 else passed
        return progress

    @cached_property
    def progress_of_all(self) -> Array:
        """Share of all sessions, with pauses between them, that had passed at each pose, (n,), from 0 to 1."""
        session = np.unique(self.dataset.session_of_pose, return_inverse=True)[1]
        passed = (1.0 + PAUSE) * session + self.progress
        return np.asarray(passed / ((1.0 + PAUSE) * session.max(initial=0) + 1.0))

    @cached_property
    def fitted_k2(self) -> Bools:
        """Whether the own parameters of each row's sensor have a second radial term, (m,); (1,) for all rows alike."""
        parts = parts_with_lens(self.dataset)
        fitted = np.array(["k2" in fitted_lens(part) for part in parts])
        seeing = fitted[["pixel" in part.format.columns for part in parts]]
        return seeing[:1] if seeing.all() or not seeing.any() else fitted[self.dataset.sensor_of_row]

    @cached_property
    def rise(self) -> Array | None:
        """Temperature above the lowest over the largest such rise, (n,); None where it is unknown or constant."""
        return self.course.rise if self.course is not None else temperature_rise(self.poses)

    def course_at(self, chosen: Bools) -> Course | None:
        """Progress of the run at some of its poses, (n,); None where their order is unknown."""
        if self.poses.time_s is None:
            return None
        rise = None if self.rise is None else self.rise[chosen]
        return Course(self.progress[chosen], rise, by_thermometer=self.poses.temperature_c is not None)

    @property
    def reference(self) -> "Run":
        """The run to whose loads, poses and points effects are relative: the whole, where this is a part."""
        whole = self.dataset.whole
        if whole is None:
            return self
        known: Run = whole.__dict__.setdefault(RUN, Run(whole))
        return known

    @cached_property
    def approach(self) -> Array:
        """The direction in which each joint last moved before each pose, (n, j): +1, -1, or 0 before its first move."""
        direction = np.zeros_like(self.q)
        for before, now in (step for path in self.paths for step in pairwise(path)):
            sign = np.sign(self.q[now] - self.q[before])
            direction[now] = np.where(sign == 0, direction[before], sign)
        return direction

    @cached_property
    def loads(self) -> Loads:
        """Loads of the arm at the angles read."""
        return Loads(self.robot, self.q, self.poses.payload_kg)

    @cached_property
    def gravity_in_flange(self) -> Array:
        """The direction of gravity in the flange frame, unit vectors (n, 3)."""
        down = gravity_of(self.dataset)
        return np.asarray((down / np.linalg.norm(down)) @ self.flange[:, :3, :3])

    @cached_property
    def flange(self) -> Array:
        """T_base_flange by the nominal arm or the measurement, (n, 4, 4)."""
        return self.dataset.flange()

    @cached_property
    def view_in_flange(self) -> Array:
        """The direction in which a tracker looks at each row's reflector, in the flange frame, unit vectors (m, 3).

        Where the tracker stands follows from all rows of a session, by the nominal arm.
        """
        points, view = self.points, np.empty((len(self.points), 3))
        T, session = self.flange[points.pose], self.dataset.session_of_pose[points.pose]
        for rows in (np.flatnonzero(session == number) for number in np.unique(session)):
            xyz, reflector = points["xyz"][rows], np.unique(points.number[rows], return_inverse=True)[1]
            R, *_ = base_and_tools(xyz[None], T[None, rows], reflector)
            view[rows] = np.einsum("mji,mj->mi", R[0] @ T[rows, :3, :3], xyz)
        return np.asarray(view / np.linalg.norm(view, axis=1, keepdims=True))

    @cached_property
    def target(self) -> TargetPlane:
        """The plane of the target points, in the frame that they are given in."""
        if self.reference is not self:
            return self.reference.target
        seen = [sensor.data.points for sensor in self.dataset.sensors]
        with_target = [points["xyz"] for points in seen if points.pixel is not None]
        return plane_of(np.concatenate(with_target) if with_target else self.points["xyz"])

    @cached_property
    def relative_range(self) -> Array:
        """Relative excess of each row's distance from its camera over the mean, by the nominal model, (m,)."""
        ranges, of_whole = self._ranges, self.reference._ranges
        return np.zeros(len(self.points)) if ranges is None or of_whole is None else ranges / of_whole.mean() - 1.0

    @cached_property
    def _ranges(self) -> Array | None:
        """Distance of each row's point from its camera by the nominal model, (m,) [m]; None where some have none."""
        return Blocks(self.dataset).ranges(self.reference._nominal, self.flange[None], Perturbation())

    @cached_property
    def _nominal(self) -> Values:
        """The sensors' nominal parameters, (1,) each."""
        items = parameters_of(Blocks(self.dataset), self.flange[None]).items
        return {item.name: np.array([item.nominal]) for item in items}

    @cached_property
    def tilt(self) -> Array:
        """Tangent of the surface's tilt against each ray, across the stripe, by the nominal model, (m,).

        Zero in rows of sensors that are no scanners.
        """
        tilt = np.zeros(len(self.points))
        for block in self._scanners:
            tilt[block.rows] = surface_tilt(block.sensor.dataset, self.flange, self.target)
        return tilt

    @cached_property
    def laser_angle(self) -> Array:
        """The nominal θ of each row's scanner, (m,) [rad]; (1,) for all rows alike, 0 in rows of other sensors."""
        if len(self.dataset.sensors) == 1:
            return np.array([self.dataset.parameters["theta"].nominal])
        angle = np.zeros(len(self.points))
        for block in self._scanners:
            angle[block.rows] = block.sensor.dataset.parameters["theta"].nominal
        return angle

    @cached_property
    def _scanners(self) -> tuple[Block, ...]:
        """The blocks of stripe scanners."""
        return tuple(block for block in blocks_of(self.dataset) if block.sensor.has_laser_plane())


@final
@dataclass(frozen=True)
class RunSummary:
    """The run that a calibration was made from."""

    poses: Annotated[int, Meta(ge=1)]  # number of poses
    sha256: str  # digest of names, readings and times: identifies a run with the same poses
    # middle of all flanges by the nominal arm, about which `base_shift` turns, (3,) [m]
    middle_m: Annotated[list[float], Meta(min_length=3, max_length=3)]
    # the lowest and highest temperature [°C]; None where it was not measured
    temperature_c: Annotated[list[float], Meta(min_length=2, max_length=2)] | None

    @classmethod
    def of(cls, dataset: Dataset) -> "RunSummary":
        """The run in which a data set was measured."""
        poses = dataset.poses
        digest = hashlib.sha256("\0".join(poses.names).encode())
        for numbers in (poses.time_s, poses.q, poses.T_base_flange):
            digest.update(b"" if numbers is None else np.ascontiguousarray(numbers, "<f8").tobytes())
        read = poses.temperature_c
        return cls(
            poses=len(poses),
            sha256=digest.hexdigest(),
            middle_m=dataset.flange()[:, :3, 3].mean(axis=0).tolist(),
            temperature_c=None if read is None else [float(read.min()), float(read.max())],
        )


def continued(summary: RunSummary | None, dataset: Dataset) -> Run:
    """Another data set as a later part of a run, of which nothing may be known.

    All its poses count as taken at the end of that run, warmed up, or by temperatures where both have them.
    """
    n = len(dataset.poses)
    low, high = [0.0, 0.0] if summary is None or summary.temperature_c is None else summary.temperature_c
    read = dataset.poses.temperature_c
    rise = None if low == high else np.ones(n) if read is None else (read - low) / (high - low)
    return Run(dataset, Course(np.ones(n), rise, by_thermometer=rise is not None and read is not None))


def gravity_of(dataset: Dataset) -> Array:
    """Gravity in the base frame, (3,) [m/s²]; downwards unless the arm states otherwise."""
    return np.array(DOWN if dataset.robot is None else dataset.robot.gravity)


def temperature_rise(poses: Poses) -> Array | None:
    """Temperature above the lowest over the largest such rise, (n,), 0 to 1; None where it is unknown or constant."""
    read = poses.temperature_c
    if read is None or np.ptp(read) == 0:
        return None
    return np.asarray((read - read.min()) / np.ptp(read))
