"""Joints whose zero is not where the controller believes it to be."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_robot
from robolaser.model.effects.places import moved, moving_joints
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class JointOffset(Effect):
    """A constant error of one joint's zero: q' = q + offset."""

    name: ClassVar[str] = "joint_offset"
    title: ClassVar[str] = "constant error of the joint's zero"
    reference: ClassVar[str] = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration; homing leaves 0.1°"
    stage: ClassVar[Stage] = Stage.JOINTS

    offset: Array = parameter(unit="rad", bound=0.1, prior_scale=1.7e-3)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles."""
        return no_robot(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return moving_joints(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Add the offset to the joint's column."""
        return moved(value, scene, self.where, self.offset[:, None])
