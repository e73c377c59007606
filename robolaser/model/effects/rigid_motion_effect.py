"""Rigid motions in the course of a run, of which a share has happened at each pose."""

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, parameter
from robolaser.model.effects.run_summary import RunSummary


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


@dataclass(frozen=True)
class MountMotion(RigidMotion):
    """Of what the flange carries in the flange's frame, or of a camera in its own."""

    def apply(self, T: Array, run: Run, /) -> Array:
        """The poses (c, n, 4, 4), moved in their own frames."""
        shift, turn = self.motion(run)
        moved: Array = T @ pose(turn, shift)
        return moved


@dataclass(frozen=True)
class BaseMotion(RigidMotion):
    """Of the flange in the base frame: turned about the middle of all flanges, which keeps turn and shift separable."""

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        """The moved flange."""
        shift, turn = self.motion(run)
        turned = turn - np.eye(3)
        middle = run.reference.flange[:, :3, 3].mean(axis=0)
        R, t = T_base_flange[..., :3, :3], T_base_flange[..., :3, 3]
        return pose(R + turned @ R, t + (turned @ (t - middle)[..., None])[..., 0] + shift)

    def about_middle_of(self, run: Run, found_in: RunSummary | None) -> Self:
        """The same motion about the middle of another run than the one that it was found in."""
        if found_in is None:
            return self
        apart = run.flange[:, :3, 3].mean(axis=0) - np.array(found_in.middle_m)
        turn = exp_so3(np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1))[0]
        x, y, z = (turn - np.eye(3)) @ apart
        return replace(self, x=self.x + x, y=self.y + y, z=self.z + z)
