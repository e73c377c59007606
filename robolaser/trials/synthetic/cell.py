"""True cells: an arm with a scanner over a stepped target or with a tracker, and their readings with given faults."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Points
from robolaser.geometry.rigid_motion import apply
from robolaser.trials.synthetic.fault_model import FaultModel, SyntheticRun, flange_poses
from robolaser.trials.synthetic.scanner import ScannerOptics


@final
@dataclass(frozen=True)
class Target:
    """Parallel flat steps."""

    middle: Array  # (3,) in the base frame [m]
    axes: Array  # two in the steps and their normal, as rows, (3, 3)

    def inside(self, point: Array) -> Array:
        """Points of the base frame as two coordinates in the steps and a height, (m, 3)."""
        return (point - self.middle) @ self.axes.T

    def outside(self, inside: Array) -> Array:
        """And back."""
        return inside @ self.axes + self.middle


@final
@dataclass(frozen=True)
class ScannerCell:
    """A scanner on an arm over a target: the true cell without faults."""

    run: SyntheticRun  # of the arm
    eye: ScannerOptics  # the scanner
    target: Target  # below the scanner
    pose: Ints  # number of each point's pose, (m,)
    at: Array  # pixel coordinate along the stripe at which each point is read, (m,) [px]
    level: Array  # height of each point's step, (m,) [m]

    @property
    def truth(self) -> Mapping[str, float]:
        """The sensor's ordinary parameters."""
        return self.eye.truth

    def ranges(self, points: Points) -> Array:
        """Distances of points from a camera without faults, (m,) [m]."""
        T_base_camera = self.run.arm.forward(self.run.q) @ self.eye.mount
        return np.asarray(np.linalg.norm(points["xyz"] - T_base_camera[points.pose, :3, 3], axis=1))

    def seen(self, faults: Sequence[FaultModel]) -> Points:
        """Compute the chain from the joints to the pixels (NaN where the light does not meet the target).

        Target points are nominal, in the base frame; names are their numbers in the pose.
        """
        run, n = self.run, len(self.run.q)
        mount, light, terms = np.tile(self.eye.mount, (n, 1, 1)), self.eye.light(n), self.eye.lens
        for fault in faults:
            mount = fault.mount(mount, run)
            light, terms = fault.light(light, run), fault.lens(terms)
        T = (flange_poses(run, faults) @ mount)[self.pose]

        def shown(point: Array) -> Array:
            larger = sum((fault.zoom(point[:, 2]) for fault in faults), start=np.zeros(len(point)))
            return self.eye.pixels(point, terms, larger)

        def inside(point: Array) -> Array:
            return self.target.inside(apply(T, point))

        def height(along: Array) -> Array:
            return sum((fault.height(along, run) for fault in faults), start=np.zeros(len(along)))

        def above(point: Array) -> Array:
            local = inside(point)
            return local[:, 2] - self.level - height(local[:, :2])

        normal = self.target.axes[2] @ T[:, :3, :3]
        depth = (self.level - inside(np.zeros((len(T), 3)))[:, 2]) / normal[:, 2]
        ahead = depth[:, None] * np.array([0.0, 0.0, 1.0])  # point of the step on the optical axis
        point, pixel = self.eye.meet(self.at, light.of_rows(self.pose), shown, above, ahead)
        tilt = np.arctan2(normal[:, 0], -normal[:, 2])
        across = 1 if self.eye.stripe_axis == "u" else 0
        pixel[:, across] += sum(fault.stripe(tilt) for fault in faults)
        along = inside(point)[:, :2]
        for fault in faults:
            along = fault.printed(along, run)
        number = np.arange(len(self.pose)) - np.searchsorted(self.pose, self.pose)
        xyz = self.target.outside(np.column_stack([along, self.level]))
        return Points(self.pose, tuple(map(str, number.tolist())), pixel=pixel, xyz=xyz)


@final
@dataclass(frozen=True)
class TrackerCell:
    """A tracker that sees all reflectors of a flange in each pose: the true cell without faults."""

    run: SyntheticRun  # of the arm
    T_world_base: Array  # (4, 4)
    reflectors: Mapping[str, Array]  # in the flange's frame, by name, (3,) [m]

    @property
    def truth(self) -> Mapping[str, float]:
        """Empty: all parameters of the sensor follow from the points."""
        return {}

    def ranges(self, points: Points) -> Array:
        """Distances of points from the tracker, (m,) [m]."""
        return np.asarray(np.linalg.norm(points["xyz"], axis=1))

    def seen(self, faults: Sequence[FaultModel]) -> Points:
        """Compute the chain from the joints to the points in the tracker's frame."""
        T = self.T_world_base @ flange_poses(self.run, faults)
        xyz = apply(T[:, None], np.array(list(self.reflectors.values()))).reshape(-1, 3)
        for fault in faults:
            xyz = fault.measured(xyz)
        pose = np.repeat(np.arange(len(T)), len(self.reflectors))
        return Points(pose, tuple(self.reflectors) * len(T), xyz=xyz)
