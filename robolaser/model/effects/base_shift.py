"""Robots or targets that were knocked, or moved, at some moment of the run."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_order
from robolaser.model.stages import Stage

LEAST = 3  # poses before and after: fewer are fitted by any six numbers


@final
@dataclass(frozen=True)
class BaseShift(Effect):
    """After a moment of the run the flange stands elsewhere: turned about the middle of all flanges, then shifted.

    A target that was moved looks the same, the other way round. Turning about the middle, and not about the base,
    keeps turn and shift apart.
    """

    name: ClassVar[str] = "base_shift"
    title: ClassVar[str] = "the robot or target was moved at some moment of the run"
    reference: ClassVar[str] = (
        "Page 1954, Continuous inspection schemes, for steps in a series; cell practice: 0.1-5 mm"
    )
    stage: ClassVar[Stage] = Stage.FLANGE
    depends_on_trajectory: ClassVar[bool] = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    moment: Array = shape(unit="", lower=0.0, upper=1.0, nominal=0.5)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """The order of poses, and enough of them."""
        few = f"fewer than {2 * LEAST} poses" if len(dataset.poses) < 2 * LEAST else ""
        return no_order(dataset) or few

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The base."""
        return () if cls.missing(dataset) else ("base",)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """The middle of each pause between poses with points, (g, 1), some poses left on either side."""
        scene = Scene.of(dataset)
        seen = np.unique(dataset.points.pose)
        at = np.sort(scene.progress[seen])
        moments = (at[LEAST - 1 : -LEAST] + at[LEAST : len(at) - LEAST + 1]) / 2
        return np.unique(moments if len(moments) else [0.5])[:, None]

    def apply(self, value: Array, scene: Scene) -> Array:
        """Move the flange in the poses that came later."""
        later = scene.progress > self.moment[:, None]
        turn = np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1)
        shift = np.stack([self.x, self.y, self.z], axis=-1)
        turned = later[..., None, None] * (exp_so3(turn) - np.eye(3))[:, None]
        middle = scene.flange[:, :3, 3].mean(axis=0)
        moved = np.broadcast_to(value, (len(shift), *value.shape[1:])).copy()
        moved[..., :3, :3] += turned @ value[..., :3, :3]
        arm = value[..., :3, 3] - middle
        moved[..., :3, 3] += np.einsum("cnij,cnj->cni", turned, np.broadcast_to(arm, (len(shift), *arm.shape[1:])))
        moved[..., :3, 3] += later[..., None] * shift[:, None]
        return moved
