"""Rigid motions in the course of a run, of which a share has happened at each pose."""

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Final, Self

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import NOT_WARM, CarryOver, Effect, Run, RunSummary, nonlinear, parameter
from robolaser.model.effects.requirements import pose_order
from robolaser.model.effects.thermal_state import crept

SETTLINGS = (0.0, 1.5, 3.5, 8.0)  # of a creep, to try: even with the first, over in a third of the run with the last
FEWEST: Final = 3  # poses before and after a moment: any six numbers fit fewer


def enough_poses(dataset: Dataset) -> str:
    """There are enough poses before and after any moment."""
    return f"fewer than {2 * FEWEST} poses" if len(dataset.poses) < 2 * FEWEST else ""


def moments(run: Run) -> Array:
    """The middle of each pause between poses with points as a share of the run, (g,), enough poses on either side."""
    at = np.sort(run.progress_of_all[np.unique(run.dataset.points.pose)])
    between = (at[FEWEST - 1 : -FEWEST] + at[FEWEST : len(at) - FEWEST + 1]) / 2
    return np.unique(between if len(between) else [0.5])


@dataclass(frozen=True)
class RigidMotion(Effect):
    """A shift [m], and a turn by a rotation vector [rad]."""

    depends_on_trajectory = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    turn_x: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_y: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_z: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)

    @abstractmethod
    def share(self, run: Run) -> Array | Bools:
        """The share that has happened at each pose, (c, n)."""

    def motion(self, run: Run) -> tuple[Array, Array]:
        """The shift (c, n, 3) and the rotation (c, n, 3, 3) at each pose."""
        share = self.share(run)[..., None]
        shift = np.stack([self.x, self.y, self.z], axis=-1)[:, None]
        turn = np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1)[:, None]
        return share * shift, exp_so3(share * turn)

    def about_middle_of(self, run: Run, found_in: RunSummary | None) -> Self:
        """The same motion in another run than the one that it was found in."""
        return self


@dataclass(frozen=True)
class Creep(RigidMotion):
    r"""A share :math:`g = (1 - e^{-s\,p}) / (1 - e^{-s})` at the run's progress p, where s is `settling`."""

    settling: Array = nonlinear(unit="", lower=0.0, upper=SETTLINGS[-1], nominal=0.0, tried=SETTLINGS)

    def share(self, run: Run) -> Array:
        return crept(run.progress, self.settling)

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It stays as at the end of the run that it was found in."""
        return CarryOver(self.about_middle_of(run, found_in), NOT_WARM, alternatives=(None,))


@dataclass(frozen=True)
class Shift(RigidMotion):
    """All of it at a moment of the run; of several sessions the moment is in one."""

    after: ClassVar[str]  # what is taken to be as it was after the shift

    needs = (pose_order, enough_poses)
    begins = True

    moment: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=0.5)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Each pause between poses with points, (g, 1)."""
        return moments(Run(dataset))[:, None]

    def share(self, run: Run) -> Bools:
        return np.asarray(run.progress_of_all > self.moment[:, None])

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """All poses are after the shift."""
        doubt = f"{self.after}. If it was moved again, calibrate again"
        return CarryOver(self.about_middle_of(run, found_in), doubt)


@dataclass(frozen=True)
class MountMotion(RigidMotion):
    """Of what the flange carries in the flange's frame, or of a camera in its own."""

    def apply(self, T: Array, run: Run, /) -> Array:
        """The poses (c, n, 4, 4), moved in their own frames."""
        shift, turn = self.motion(run)
        return T @ pose(turn, shift)


@dataclass(frozen=True)
class BaseMotion(RigidMotion):
    """Of the flange in the base frame: turned about the middle of all flanges, which keeps turn and shift separable."""

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        shift, turn = self.motion(run)
        turned = turn - np.eye(3)
        middle = run.reference.flange[:, :3, 3].mean(axis=0)
        R, t = T_base_flange[..., :3, :3], T_base_flange[..., :3, 3]
        return pose(R + turned @ R, t + (turned @ (t - middle)[..., None])[..., 0] + shift)

    def about_middle_of(self, run: Run, found_in: RunSummary | None) -> Self:
        """About the middle of that run."""
        if found_in is None:
            return self
        apart = run.flange[:, :3, 3].mean(axis=0) - np.array(found_in.middle_m)
        turn = exp_so3(np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1))[0]
        x, y, z = (turn - np.eye(3)) @ apart
        return replace(self, x=self.x + x, y=self.y + y, z=self.z + z)
