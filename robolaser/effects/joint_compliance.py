"""Gearboxes that give way under the weight of the arm."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.effect import Effect, Scene, parameter
from robolaser.effects.lacking import no_weight
from robolaser.effects.places import joint_column, moving_joints, spread
from robolaser.seams import Seam


@final
@dataclass(frozen=True)
class JointCompliance(Effect):
    """A joint behind its encoder yields to what it bears: q' = q - compliance g(q), g the gravity torque.

    It is taken at the angles read, from the URDF's masses and the payload. What the arm weighs in truth scales the
    number: a URDF that is 10 % too light makes it 10 % too large.
    """

    name: ClassVar[str] = "joint_compliance"
    title: ClassVar[str] = "gives way under the gravity torque of the URDF's masses"
    reference: ClassVar[str] = "Siciliano, Khatib 2016, Springer Handbook of Robotics, ch. 11; stiffness 1e4-5e4 Nm/rad"
    seam: ClassVar[Seam] = Seam.JOINTS

    compliance: Array = parameter(unit="rad/Nm", bound=2e-3, typical=1e-4)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles, and masses."""
        return no_weight(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return () if cls.missing(dataset) else moving_joints(dataset)

    def bend(self, passing: Array, scene: Scene) -> Array:
        """Let the joint sink by compliance times torque."""
        column = joint_column(scene, self.where)
        bent = spread(passing, len(self.compliance))
        bent[:, :, column] -= self.compliance[:, None] * scene.gravity_torques[:, column]
        return bent
