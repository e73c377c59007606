"""Encoders that count too many or too few steps to a turn, or drive ratios other than the controller believes."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_robot
from robolaser.model.effects.places import joint_column, moved, moving_joints
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class EncoderScale(Effect):
    """A gain error: q' = q (1 + scale)."""

    name: ClassVar[str] = "encoder_scale"
    title: ClassVar[str] = "gain error of the joint's reading"
    reference: ClassVar[str] = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration, ch. 2"
    stage: ClassVar[Stage] = Stage.JOINTS

    scale: Array = parameter(unit="", bound=0.05, prior_scale=1e-3)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles."""
        return no_robot(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return moving_joints(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Stretch the joint's column."""
        q = value[:, :, joint_column(scene, self.where)]
        return moved(value, scene, self.where, self.scale[:, None] * q)
