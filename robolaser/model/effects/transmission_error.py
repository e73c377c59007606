"""Harmonic drives and gears with an error that is periodic in the motor's angle."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Run, Stage, nonlinear, parameter
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.requirements import turning_joint

FEWEST, MOST = 10.0, 330.0
"""Cycles a joint turn: fewer are dead zones and cables; a harmonic drive has at most twice 160."""
STEP = 2.0  # of the phase over the joint's range [rad]: half a step off, a wave still fits 92 % of itself


@final
@dataclass(frozen=True)
class TransmissionError(Effect):
    r"""Two harmonics: :math:`q' = q + s \sin Nq + c \cos Nq + s_2 \sin 2Nq + c_2 \cos 2Nq`, N cycles a joint turn.

    The error of a harmonic drive has one and two periods per turn of its wave generator.
    """

    name = "transmission_error"
    title = "periodic in the motor's angle: several cycles per joint turn"
    clause = "the gear of {where} has a periodic error"
    caveat = "its frequency is the best of several that were tried"
    remedy = "Correct {where} by the model, or have its gear inspected."
    reference = "Tuttle, Seering 1996, A nonlinear model of a harmonic drive; 0.5-2 arcmin"
    stage = Stage.JOINTS
    cause = "transmission"
    needs = (turning_joint,)
    harmonics = (1, 2)

    sine: Array = parameter(unit="rad", bound=0.01, prior_scale=3e-4)
    cosine: Array = parameter(unit="rad", bound=0.01, prior_scale=3e-4)
    sine_2: Array = parameter(unit="rad", bound=0.01, prior_scale=1e-4)
    cosine_2: Array = parameter(unit="rad", bound=0.01, prior_scale=1e-4)
    cycles: Array = nonlinear(unit="", lower=FEWEST, upper=MOST, nominal=20.0)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Frequencies that the joint's range can distinguish, (g, 1): some hundred for a wide range."""
        run = Run(dataset)
        span = float(np.ptp(run.q[:, joint_column(run, where)]))
        count = max(2, int(np.ceil((MOST - FEWEST) * span / STEP)) + 1)
        return np.linspace(FEWEST, MOST, count)[:, None]

    def apply(self, q: Array, run: Run, /) -> Array:
        phase = self.cycles[:, None] * q[:, :, joint_column(run, self.where)]
        sin, cos = np.sin(phase), np.cos(phase)
        once = self.sine[:, None] * sin + self.cosine[:, None] * cos
        twice = self.sine_2[:, None] * 2 * sin * cos + self.cosine_2[:, None] * (1 - 2 * sin**2)
        return add_to_joint(q, run, self.where, once + twice)
