"""Faults around the arm: its base, the target, and the tracker."""

from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.trials.synthetic.fault_model import Angle, FaultModel, OnTarget, SyntheticRun, Way, uniform


@final
class BumpedBase(FaultModel, effect="base_shift", sizes=(2e-4, 1.5e-3), location="base"):
    """The base or the target is bumped during the run: from one pose on, it is displaced."""

    moment: Annotated[float, uniform(0.2, 0.8)]  # as a share of the run
    way: Way

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """The shift at the mean position of the flange, and the rotation."""
        bump, apart = self._bump(run), run.arm.forward(run.q)[:, :3, 3].mean(axis=0)
        shift = bump[:3, :3] @ apart + bump[:3, 3] - apart
        names = ("x", "y", "z", "turn_x", "turn_y", "turn_z", "moment")
        turn = self.size * np.array(self.way[3:])
        return dict(zip(names, (*shift.tolist(), *turn.tolist(), self.moment), strict=True))

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """Moved by up to `size` [m] and turned by up to as many radians, about the target."""
        return np.where((run.share > self.moment)[:, None, None], self._bump(run) @ T_base_flange, T_base_flange)

    def _bump(self, run: SyntheticRun) -> Array:
        way = self.size * np.array(self.way)
        R = exp_so3(way[3:])
        return pose(R, way[:3] + run.middle - R @ run.middle)


@final
class YieldingFloor(FaultModel, effect="base_compliance", sizes=(2e-4, 3e-3), location="base"):
    """The floor deflects under the arm's overturning moment, under one edge of the foot more than under another.

    Anchors that are pressed down are stiffer than those that are pulled.
    """

    softer: Annotated[float, uniform(-0.3, 0.3)]  # about x than about y
    pulled: Annotated[float, uniform(0.0, 0.15)]  # additional compliance of an anchor under a pull

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        """A base that tilts turns the first joint's axis."""
        return self.where, run.joints[0]

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """Tilted about the foot, by `size` [rad] under the largest moment of the run."""
        moment = run.arm.overturning(run.q, run.payload_kg)
        load = moment / max(1e-9, float(np.linalg.norm(moment, axis=1).max()))
        load = load * (1.0 + self.pulled * np.tanh(3.0 * load)) * [1.0 + self.softer, 1.0 - self.softer, 0.0]
        return np.asarray(pose(exp_so3(self.size * load), np.zeros(3)) @ T_base_flange)


@final
class WrongRefractiveIndex(
    FaultModel,
    effect="tracker_scale",
    sizes=(2e-5, 1e-3),
    signed=True,
    location="measuring_system",
    parameter="scale",
    also=(("arm_scale", "base"),),
):
    """The tracker's correction for air is wrong: all its lengths are too long by the share `size`.

    Without a known length, this is indistinguishable from a grown arm.
    """

    def measured(self, points: Array) -> Array:
        return points * (1.0 + self.size)


@final
class PrintScale(
    FaultModel, effect="target_scale", sizes=(5e-4, 1.2e-2), signed=True, location="target", parameter="scale"
):
    """The target was printed too large or too small: nominal distances are off by the share `size`."""

    aside: OnTarget  # the grid's origin

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        origin = run.radius * np.array(self.aside)
        return origin + (along - origin) / (1.0 + self.size)


@final
class FedTooFast(
    FaultModel, effect="target_stretch", sizes=(1e-3, 1.5e-2), signed=True, location="target", parameter="stretch"
):
    """The printer fed its paper too fast: nominal coordinates are too long in that direction, by the share `size`."""

    heading: Angle

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        fed = np.array([np.cos(self.heading), np.sin(self.heading)])
        return np.asarray(along - (self.size / (1.0 + self.size) * (along @ fed))[:, None] * fed)


@final
class CurvedTarget(FaultModel, effect="target_warp", sizes=(1e-4, 1.5e-3), location="target"):
    """The target is not flat: a roof tile, a saddle or a wave."""

    shape: Annotated[str, lambda where, run, rng: str(rng.choice(["tile", "saddle", "wave"]))]
    heading: Angle
    length: Annotated[float, uniform(1.5, 4.0)]  # of the wave, over the target's radius

    def height(self, along: Array, run: SyntheticRun) -> Array:
        """About `size` [m] at the rim."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x, y = along[:, 0] / run.radius, along[:, 1] / run.radius
        x, y = cos * x + sin * y, cos * y - sin * x
        shapes = {"tile": x**2, "saddle": x * y, "wave": np.sin(2 * np.pi * x / self.length)}
        return np.asarray(self.size * shapes[self.shape])


@final
class TargetDent(FaultModel, effect="dented_target", sizes=(3e-4, 1.5e-3), location="target", classes=("target",)):
    """The target has a bell-shaped dent, `size` [m] deep and some centimetres wide; the library has no such effect."""

    aside: OnTarget
    width: Annotated[float, uniform(0.03, 0.09)]  # [m]

    def height(self, along: Array, run: SyntheticRun) -> Array:
        away = (along - run.radius * np.array(self.aside)) / self.width
        return np.asarray(-self.size * np.exp(-0.5 * (away**2).sum(axis=1)))
