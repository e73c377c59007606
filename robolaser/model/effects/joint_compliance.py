"""Gearboxes that give way under the weight of the arm."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_weight
from robolaser.model.effects.places import joint_column, moved, moving_joints
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class JointCompliance(Effect):
    """A joint behind its encoder yields to what it bears: q' = q - d, d = compliance g + payload g1, hardened.

    g is the gravity torque at the angles read, from the URDF's masses and the payload that is written down. What the
    arm weighs in truth scales the number: a URDF that is 10 % too light makes it 10 % too large. g1 is the torque of
    one kilogram at the flange, where scanner and cables weigh what no URDF says: `payload` is their mass times the
    compliance. Gears stiffen as they wind up: d (1 - hardening |d| / max |d|); below zero they soften.
    """

    name: ClassVar[str] = "joint_compliance"
    title: ClassVar[str] = "gives way under the gravity torque of the URDF's masses"
    reference: ClassVar[str] = "Siciliano, Khatib 2016, Springer Handbook of Robotics, ch. 11; stiffness 1e4-5e4 Nm/rad"
    stage: ClassVar[Stage] = Stage.JOINTS
    depends_on_trajectory: ClassVar[bool] = True

    compliance: Array = parameter(unit="rad/Nm", bound=2e-3, prior_scale=1e-4)
    payload: Array = parameter(unit="kg rad/Nm", bound=1e-2, prior_scale=1e-4)
    hardening: Array = shape(unit="", lower=-1.0, upper=1.0, nominal=0.0)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles, and masses."""
        return no_weight(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return () if cls.missing(dataset) else moving_joints(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Let the joint sink."""
        column = joint_column(scene, self.where)
        g, of_one_kg = scene.gravity_torques[:, column], scene.torques_of_one_kg[:, column]
        wound = self.compliance[:, None] * g + self.payload[:, None] * of_one_kg
        most = np.abs(wound).max(axis=1, keepdims=True)
        share = np.abs(wound) / np.where(most > 0, most, 1.0)
        return moved(value, scene, self.where, -wound * (1.0 - self.hardening[:, None] * share))
