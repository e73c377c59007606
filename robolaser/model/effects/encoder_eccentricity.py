"""Encoder discs that are not centred on their shaft, so that the reading errs once a turn."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_robot
from robolaser.model.effects.places import joint_column, moved, turning_joints
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class EncoderEccentricity(Effect):
    """An error of one cycle a joint turn: q' = q + sine sin q + cosine cos q.

    A disc of radius r that runs out by e errs by up to e / r.
    """

    name: ClassVar[str] = "encoder_eccentricity"
    title: ClassVar[str] = "error of the joint's reading, once a joint turn"
    reference: ClassVar[str] = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration, ch. 2"
    stage: ClassVar[Stage] = Stage.JOINTS

    sine: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    cosine: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles."""
        return no_robot(dataset) or ("" if turning_joints(dataset) else "no joint of this arm turns")

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that turns the flange."""
        return turning_joints(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Add the wave."""
        q = value[:, :, joint_column(scene, self.where)]
        return moved(value, scene, self.where, self.sine[:, None] * np.sin(q) + self.cosine[:, None] * np.cos(q))
