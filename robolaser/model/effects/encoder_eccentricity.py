"""Encoder discs that are not centred on their shaft, so that the reading has an error with one period per turn."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.requirements import turning_joint


@final
@dataclass(frozen=True)
class EncoderEccentricity(Effect):
    """An error of one cycle a joint turn: q' = q + sine sin q + cosine cos q.

    A disc of radius r with a run-out of e has an error of up to e / r.
    """

    name = "encoder_eccentricity"
    title = "error of the reading with one period per joint turn"
    clause = "the reading of {where} has an error with one period per turn"
    caveat = (
        "known only over the angles that these poses span; a counterweight or spring that the URDF lacks looks the same"
    )
    remedy = "Correct {where} by the model, or have its encoder centred."
    reference = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration, ch. 2"
    stage = Stage.JOINTS
    cause = "transmission"
    needs = (turning_joint,)

    sine: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    cosine: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)

    def apply(self, q: Array, run: Run, /) -> Array:
        angle = q[:, :, joint_column(run, self.where)]
        wave = self.sine[:, None] * np.sin(angle) + self.cosine[:, None] * np.cos(angle)
        return add_to_joint(q, run, self.where, wave)
