"""Links that bend and twist under load."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, Stage, nonlinear, parameter
from robolaser.model.effects.joints import joint_column, moving_joints, placed_anew
from robolaser.model.effects.requirements import masses
from robolaser.robot.kinematics import Robot

SHORTEST_M = 1e-4


@final
@dataclass(frozen=True)
class LinkCompliance(Effect):
    r"""The link from the joint before to this one turns by :math:`φ = C M` about a point on its line.

    M is the moment about that point of the weight beyond it, and
    :math:`C = \mathrm{bending}\,(1 - u u^T - (1 - \mathrm{axial})\,a a^T) + \mathrm{twist}\,u u^T`, with a the axis
    of this joint and u the part of the link's direction across it. Where `axial` is 0, the link bends across the
    joint's axis only, as a tilting bearing does; about it, it is indistinguishable from joint compliance. `hinge` is
    the point's position on the line between the joints, from the joint before (0) to this one (1); of the link's own
    weight the share beyond that point counts, and `payload` is a mass at the flange that neither URDF nor data state.
    A beam of constant section acts like a hinge in its middle: exactly for the turn of its end, within a quarter for
    the shift.
    """

    name = "link_compliance"
    title = "the link before the joint bends or twists under the load"
    clause = "the link before {where} bends under load"
    caveat = "scales with the URDF's masses: an arm 10 % heavier than stated makes it 10 % too large"
    remedy = "Reduce the payload, stiffen the link before {where} or its bearing, or keep the corrected model."
    reference = "Tenhumberg, Bäuml 2021, Calibration of an elastic humanoid upper body; 1e-6-1e-5 rad/Nm"
    stage = Stage.LINKS
    cause = "elasticity"
    needs = (masses,)

    bending: Array = parameter(unit="rad/Nm", bound=2e-3, prior_scale=2e-5, lower=0.0)
    twist: Array = parameter(unit="rad/Nm", bound=2e-3, prior_scale=2e-5, lower=0.0)
    axial: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=1.0, tried=(1.0, 0.0))
    hinge: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=0.5, tried=(0.0, 0.5, 1.0))
    payload: Array = nonlinear(unit="kg", lower=0.0, upper=20.0, nominal=0.0)

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        """Every moving joint but the first, before which is the base."""
        return moving_joints(robot)[1:]

    def apply(self, placements: Array, run: Run, /) -> Array:
        column, load = joint_column(run, self.where), run.loads.of_link(self.where)
        axis = run.robot.axes[column]
        along = unit(load.link - axis * (load.link @ axis))
        beyond, bending = 1.0 - self.hinge[:, None, None], self.bending[:, None, None]
        across = bending * (
            np.eye(3) - np.outer(along, along) - (1.0 - self.axial[:, None, None]) * np.outer(axis, axis)
        )
        compliance = across + self.twist[:, None, None] * np.outer(along, along)
        turn = exp_so3(load.moment(beyond, self.payload[:, None, None]) @ compliance)
        motion = pose(turn, beyond * ((turn - np.eye(3)) @ load.link))
        return placed_anew(placements, run, self.where, placements[:, :, column] @ motion)


def unit(vector: Array) -> Array:
    """A vector of length one in the same direction, (3,); zero where there is none."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > SHORTEST_M else np.zeros(3)
