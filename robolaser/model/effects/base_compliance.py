"""Bases, pedestals and tables that tilt under the arm's overturning moment."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import CarryOver, Effect, Run, RunSummary, Stage, nonlinear, parameter
from robolaser.model.effects.joint_compliance import hardened, with_hardening
from robolaser.model.effects.link_compliance import unit
from robolaser.model.effects.mechanism import Footing, MechanismPart
from robolaser.model.effects.requirements import masses


@final
@dataclass(frozen=True)
class BaseCompliance(Effect):
    r"""The base turns about a point below its origin by :math:`φ = C \sum_i m_i\,r_i \times g`.

    The sum is the overturning moment of the weight that the first joint carries, the stated payload included, about
    the base's origin. It has no component along gravity, and is the same about all points below the origin; a pedestal
    turns about its foot, at `depth`. C is compliance (1 + anisotropy) about the base's x axis and compliance
    (1 - anisotropy) about its y axis; of a base on a wall, about the nearest horizontal axes. The turn is zero for the
    unloaded base. Feet and floors soften or stiffen: φ (1 - hardening \|φ\| / max \|φ\|).
    """

    name = "base_compliance"
    title = "the support tilts under the arm's overturning moment"
    clause = "the support of the arm tilts under its weight"
    caveat = "scales with the URDF's masses: an arm 10 % heavier than stated makes it 10 % too large"
    remedy = "Tighten the bolts of the base, stiffen the pedestal or table, or keep the arm nearer to its base."
    reference = "Dumas et al. 2011, Joint stiffness identification of industrial serial robots; 1e4-1e6 Nm/rad"
    stage = Stage.FLANGE
    cause = "elasticity"
    site = "base"
    needs = (masses,)
    depends_on_trajectory = True

    compliance: Array = parameter(unit="rad/Nm", bound=1e-3, prior_scale=1e-5, lower=0.0)
    # equal about both axes, and stiffer about either
    anisotropy: Array = nonlinear(unit="", lower=-1.0, upper=1.0, nominal=0.0, tried=(0.0, -0.7, 0.7))
    hardening: Array = nonlinear(unit="", lower=-1.0, upper=1.0, nominal=0.0)
    depth: Array = nonlinear(unit="m", lower=0.0, upper=2.0, nominal=0.0)

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        gravity = np.array(run.robot.gravity)
        turn = exp_so3(self._turn(run) @ horizontal_axes(gravity))
        shift = self.depth[:, None, None] * ((np.eye(3) - turn) @ unit(gravity))
        return pose(turn, shift) @ T_base_flange

    def _turn(self, run: Run) -> Array:
        """Turn of the base about each horizontal axis, (c, n, 2)."""
        compliance = self.compliance[:, None] * np.stack([1.0 + self.anisotropy, 1.0 - self.anisotropy], axis=-1)
        turn, reference = (compliance[:, None] * _moment(each) for each in (run, run.reference))
        return hardened(turn, reference, self.hardening)

    def parts(self, run: Run) -> tuple[MechanismPart, ...]:
        """Springs about the horizontal axes, by least squares where these harden."""
        turn, moment, axes = self._turn(run)[0], _moment(run), horizontal_axes(np.array(run.robot.gravity))
        worked = (turn * moment).sum(axis=0)
        soft = worked > 0.0
        stiffness = np.square(moment[:, soft]).sum(axis=0) / worked[soft]
        foot = float(self.depth[0]) * unit(np.array(run.robot.gravity))
        return (Footing(axes[soft], stiffness, foot),) if soft.any() else ()

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It acts as found, but the largest moment of other poses differs."""
        carried, unhardened = super().carried_to(run, found_in), replace(self, hardening=np.zeros(1))
        return with_hardening(carried, self.hardening, unhardened)


def _moment(run: Run) -> Array:
    """The overturning moment about each horizontal axis, (n, 2) [Nm]."""
    return run.loads.overturning_moment @ horizontal_axes(np.array(run.robot.gravity)).T


def horizontal_axes(gravity: Array) -> Array:
    """Two unit vectors across gravity, (2, 3): x and y of an upright base."""
    down = unit(gravity)
    first = np.eye(3)[0] if abs(down[0]) < np.sqrt(0.5) else np.eye(3)[2]
    x = first - down * (down @ first)
    x /= np.linalg.norm(x)
    y = np.cross(x, down)
    return np.stack([x, y * np.where(y[np.abs(y).argmax()] < 0, -1.0, 1.0)])
