"""Joints whose zero is not where the controller assumes it."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.joints import add_to_joint


@final
@dataclass(frozen=True)
class JointOffset(Effect):
    """A constant error of one joint's zero: q' = q + offset."""

    name = "joint_offset"
    title = "constant error of the joint's zero"
    clause = "the zero of {where} is wrong"
    caveat = "is relative to the zero set in the robot's controller"
    remedy = (
        "Set the zero of {where} again (`robolaser export` writes it into LeRobot's `homing_offset`), or use"
        " `robot_corrected.urdf`, which includes the offset."
    )
    reference = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration; homing leaves 0.1°"
    stage = Stage.JOINTS
    cause = "arm_geometry"
    in_urdf = True

    offset: Array = parameter(unit="rad", bound=0.1, prior_scale=1.7e-3)

    def apply(self, q: Array, run: Run, /) -> Array:
        return add_to_joint(q, run, self.where, self.offset[:, None])
