"""Encoders with too many or too few steps a turn, or drive ratios that differ from the controller's."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.mechanism import MechanismPart, MimicJoint


@final
@dataclass(frozen=True)
class EncoderScale(Effect):
    """A gain error: q' = q (1 + scale)."""

    name = "encoder_scale"
    title = "gain error of the joint's reading"
    clause = "the reading of {where} has a wrong gain"
    caveat = "known only over the angles that these poses span"
    remedy = "Correct the gear ratio or the counts per turn of {where}."
    reference = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration, ch. 2"
    stage = Stage.JOINTS
    cause = "transmission"

    scale: Array = parameter(unit="", bound=0.05, prior_scale=1e-3)

    def apply(self, q: Array, run: Run, /) -> Array:
        angle = q[:, :, joint_column(run, self.where)]
        return add_to_joint(q, run, self.where, self.scale[:, None] * angle)

    def parts(self, run: Run) -> tuple[MechanismPart, ...]:
        return (MimicJoint(self.where, self.where, float(self.scale[0])),)
