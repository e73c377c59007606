"""Links that bend and twist under what they carry."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, nonlinear, parameter
from robolaser.model.effects.joints import joint_column, moving_joints
from robolaser.model.effects.requirements import masses
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class LinkCompliance(Effect):
    r"""The link from the joint before to this one turns by :math:`φ_i = c_i M_i` about a point on its line.

    M is the moment of the weight that hangs beyond that point about it, in the frame of this joint before it turns,
    about whose axes the compliances c are: across the joint's axis the link bends or its bearing tilts, along it the
    joint itself gives way. `hinge` is where on the line between the joints it yields, from the joint before (0) to this
    one (1); of the link's own weight the share beyond that point counts. A beam of constant section acts as if hinged
    in its middle: exactly so for the turn of its end, within a quarter for the shift.
    """

    name = "link_compliance"
    title = "the link before the joint bends or twists under the load, not only about the joint's axis"
    clause = "the link before {where} bends under the weight that it carries"
    caveat = "scales with the URDF's masses: an arm 10 % heavier than stated makes it 10 % too large"
    remedy = "Reduce the payload, stiffen the link before {where} or its bearing, or keep the corrected model."
    reference = "Tenhumberg, Bäuml 2021, Calibration of an elastic humanoid upper body; 1e-6-1e-5 rad/Nm"
    stage = Stage.LINKS
    cause = "elasticity"
    needs = (masses,)

    about_x: Array = parameter(unit="rad/Nm", bound=2e-3, prior_scale=2e-5, lower=0.0)
    about_y: Array = parameter(unit="rad/Nm", bound=2e-3, prior_scale=2e-5, lower=0.0)
    about_z: Array = parameter(unit="rad/Nm", bound=2e-3, prior_scale=2e-5, lower=0.0)
    hinge: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=1.0)

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        """Every moving joint but the first: what is before that is the base."""
        return moving_joints(robot)[1:]

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """At either joint, and in the middle."""
        return np.array([[0.0], [0.5], [1.0]])

    def apply(self, placements: Array, run: Run, /) -> Array:
        """Turn the joint's placement in each pose."""
        column, load = joint_column(run, self.where), run.link_load(self.where)
        compliance = np.stack([self.about_x, self.about_y, self.about_z], axis=-1)
        beyond = 1.0 - self.hinge[:, None, None]
        turn = exp_so3(compliance[:, None] * load.moment(beyond))
        moved = np.broadcast_to(placements, (*turn.shape[:2], *placements.shape[2:])).copy()
        motion = pose(turn, beyond * ((turn - np.eye(3)) @ load.link))
        moved[:, :, column] = moved[:, :, column] @ motion
        return moved
