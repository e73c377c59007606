"""Links whose geometry or mounting is not nominal, so that the next joint is elsewhere."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.joints import joint_column, placed_anew


@final
@dataclass(frozen=True)
class LinkGeometry(Effect):
    """A small motion of one joint's placement: T' = T (exp(turn), shift), in the joint's own frame.

    If one of the six only repeats another parameter (as a turn about the joint's own axis), the calibration lists it
    as not determined by the data.
    """

    name = "link_geometry"
    title = "error of the joint's placement on the link before it"
    clause = "the placement of {where} on its link is wrong"
    caveat = "a turn about the joint's own axis (of a linear joint, a shift along it) equals a joint offset"
    remedy = "Use `robot_corrected.urdf`, which has the estimated placement of {where}."
    reference = "Hayati 1983; Stone 1987; nominal against true kinematics 1-10 mm on collaborative arms"
    stage = Stage.LINKS
    cause = "arm_geometry"
    in_urdf = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=2e-3)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=2e-3)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=2e-3)

    def apply(self, placements: Array, run: Run, /) -> Array:
        turn = np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1)
        motion = pose(exp_so3(turn), np.stack([self.x, self.y, self.z], axis=-1))
        placement = placements[:, :, joint_column(run, self.where)]
        return placed_anew(placements, run, self.where, placement @ motion[:, None])
