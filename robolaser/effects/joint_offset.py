"""Joints whose zero is not where the controller believes it to be."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.effect import Effect, Scene, parameter
from robolaser.effects.places import joint_column, moving_joints
from robolaser.seams import Seam


@final
@dataclass(frozen=True)
class JointOffset(Effect):
    """A constant error of one joint's zero: q' = q + offset."""

    name: ClassVar[str] = "joint_offset"
    title: ClassVar[str] = "constant error of the joint's zero"
    reference: ClassVar[str] = "Mooring, Roth, Driels 1991, Fundamentals of Manipulator Calibration; homing leaves 0.1°"
    seam: ClassVar[Seam] = Seam.JOINTS

    offset: Array = parameter(unit="rad", bound=0.1, typical=1.7e-3)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return moving_joints(dataset)

    def bend(self, passing: Array, scene: Scene) -> Array:
        """Add the offset to the joint's column."""
        column = joint_column(scene, self.where)
        bent = passing.repeat(len(self.offset), axis=0) if len(passing) == 1 else passing.copy()
        bent[:, :, column] += self.offset[:, None]
        return bent
