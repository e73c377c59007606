"""Harmonic drives and gears whose output runs ahead and behind, periodically in the motor's angle."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_robot
from robolaser.model.effects.places import joint_column, moved, turning_joints
from robolaser.model.stages import Stage

FEWEST, MOST = 2.0, 330.0  # cycles a joint turn: two is a bearing's, twice the 160 of a harmonic drive is most
STEP = 2.0  # of the phase over the joint's range [rad]: half a step from its best, a wave still fits 92 % of itself


@final
@dataclass(frozen=True)
class TransmissionError(Effect):
    r"""Two harmonics: :math:`q' = q + s \sin Nq + c \cos Nq + s_2 \sin 2Nq + c_2 \cos 2Nq`, N cycles a joint turn.

    A harmonic drive errs once and twice a turn of its wave generator.
    """

    name: ClassVar[str] = "transmission_error"
    title: ClassVar[str] = "periodic in the motor's angle: several cycles a joint turn"
    reference: ClassVar[str] = "Tuttle, Seering 1996, A nonlinear model of a harmonic drive; 0.5-2 arcmin"
    stage: ClassVar[Stage] = Stage.JOINTS

    sine: Array = parameter(unit="rad", bound=0.01, prior_scale=3e-4)
    cosine: Array = parameter(unit="rad", bound=0.01, prior_scale=3e-4)
    sine_2: Array = parameter(unit="rad", bound=0.01, prior_scale=1e-4)
    cosine_2: Array = parameter(unit="rad", bound=0.01, prior_scale=1e-4)
    cycles: Array = shape(unit="", lower=FEWEST, upper=MOST, nominal=20.0)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles."""
        return no_robot(dataset) or ("" if turning_joints(dataset) else "no joint of this arm turns")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that turns the flange."""
        return turning_joints(dataset)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Frequencies that the joint's range can tell apart, (g, 1): some hundred for a wide range."""
        robot, q = dataset.robot, dataset.poses.q
        assert robot is not None  # `places` says so
        assert q is not None
        span = float(np.ptp(q[:, robot.joints.index(where)]))
        count = max(2, int(np.ceil((MOST - FEWEST) * span / STEP)) + 1)
        return np.linspace(FEWEST, MOST, count)[:, None]

    def apply(self, value: Array, scene: Scene) -> Array:
        """Add the two waves."""
        phase = self.cycles[:, None] * value[:, :, joint_column(scene, self.where)]
        sin, cos = np.sin(phase), np.cos(phase)
        once = self.sine[:, None] * sin + self.cosine[:, None] * cos
        twice = self.sine_2[:, None] * 2 * sin * cos + self.cosine_2[:, None] * (1 - 2 * sin**2)
        return moved(value, scene, self.where, once + twice)
