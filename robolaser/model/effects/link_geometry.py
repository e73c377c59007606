"""Links that were not made or mounted as drawn, so that the next joint sits elsewhere."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_robot
from robolaser.model.effects.places import joint_column, moving_joints, spread
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class LinkGeometry(Effect):
    """A small motion of one joint's placement: T' = T (exp(turn), shift), in the joint's own frame.

    Where one of the six numbers only repeats another parameter (a turn about the joint's own axis, say), the
    calibration names it as one that the data cannot fix.
    """

    name: ClassVar[str] = "link_geometry"
    title: ClassVar[str] = "the joint's placement on the link before it is off"
    reference: ClassVar[str] = "Hayati 1983; Stone 1987; nominal against true kinematics 1-10 mm on collaborative arms"
    stage: ClassVar[Stage] = Stage.LINKS

    x: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=2e-3)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=2e-3)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=2e-3)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles."""
        return no_robot(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return moving_joints(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Carry the joint's placement on by the small motion."""
        column = joint_column(scene, self.where)
        turn = np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1)
        motion = pose(exp_so3(turn), np.stack([self.x, self.y, self.z], axis=-1))
        bent = spread(value, len(self.x))
        bent[:, :, column] = bent[:, :, column] @ motion[:, None]
        return bent
