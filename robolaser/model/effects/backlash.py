"""Gears with play: the link hangs back behind the motor, on the side that it was pushed from."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.course import played
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_path
from robolaser.model.effects.places import joint_column, moved, moving_joints
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class Backlash(Effect):
    """Lost motion: q' is q driven through a play of this width along the path, poses in the order of their time.

    After a move longer than the play, q' = q - lost_motion / 2 in the move's direction; after a shorter one the link
    stays, or is pushed on. The way to the first pose is not known: where in the play it stands there, from one end
    (-1) to the other (1), is a shape.
    """

    name: ClassVar[str] = "backlash"
    title: ClassVar[str] = "lost motion: depends on the direction it came from"
    reference: ClassVar[str] = "Nordin, Gutman 2002, Controlling mechanical systems with backlash; 1-2 arcmin, belts 5"
    stage: ClassVar[Stage] = Stage.JOINTS
    depends_on_trajectory: ClassVar[bool] = True

    lost_motion: Array = parameter(unit="rad", bound=0.02, prior_scale=6e-4)
    start: Array = shape(unit="", lower=-1.0, upper=1.0, nominal=0.0)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """The way that the joints went."""
        return no_path(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange."""
        return () if cls.missing(dataset) else moving_joints(dataset)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Both ends and the middle of the play."""
        return np.array([[-1.0], [0.0], [1.0]])

    def apply(self, value: Array, scene: Scene) -> Array:
        """Drive the joint through the play; a negative width pushes ahead instead of hanging back."""
        half, sign = np.abs(self.lost_motion) / 2, np.sign(self.lost_motion)
        moves = np.diff(value[:, scene.order, joint_column(scene, self.where)], axis=1)
        ahead = np.empty((len(half), len(scene.order)))
        ahead[:, scene.order] = sign[:, None] * played(half * self.start, moves, half)
        return moved(value, scene, self.where, ahead)
