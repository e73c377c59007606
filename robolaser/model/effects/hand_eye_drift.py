"""Brackets that creep or slip during the run, so that the camera moves on the flange."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_order, no_stripe
from robolaser.model.stages import Stage

SHARPEST = 8.0  # by then the bracket has settled in the first third of the run


@final
@dataclass(frozen=True)
class HandEyeDrift(Effect):
    r"""T' = T (exp(g turn), g shift), in the camera's own frame: it turns about its optical centre.

    :math:`g = (1 - e^{-s\,p}) / (1 - e^{-s})` of the run's progress p; s being `settling`: with 0 it goes
    evenly, with a larger one it settles. The numbers are what has come together at the end of the run.
    """

    name: ClassVar[str] = "hand_eye_drift"
    title: ClassVar[str] = "the bracket creeps during the run"
    reference: ClassVar[str] = "Findley, Lai, Onaran 1976, Creep and Relaxation of Nonlinear Viscoelastic Materials"
    stage: ClassVar[Stage] = Stage.MOUNT
    depends_on_trajectory: ClassVar[bool] = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    turn_x: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_y: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_z: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    settling: Array = shape(unit="", lower=0.0, upper=SHARPEST, nominal=0.0)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A camera on a bracket, and the order of poses."""
        return no_stripe(dataset, "bracket") or no_order(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The bracket."""
        return () if cls.missing(dataset) else ("hand_eye",)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """From even creep to one that soon settles."""
        return np.array([[0.0], [1.5], [3.5], [SHARPEST]])

    def apply(self, value: Array, scene: Scene) -> Array:
        """Carry the camera on."""
        share = crept(scene.progress, self.settling)[..., None]
        turn = np.stack([self.turn_x, self.turn_y, self.turn_z], axis=-1)[:, None]
        shift = np.stack([self.x, self.y, self.z], axis=-1)[:, None]
        return value @ pose(exp_so3(share * turn), share * shift)


def crept(progress: Array, settling: Array) -> Array:
    """Share of the creep that has come, (n,) and (c,) -> (c, n): 0 at the start of the run and 1 at its end."""
    rate = np.where(settling == 0, 1.0, settling)[:, None]
    with np.errstate(over="ignore"):
        curved = np.expm1(-rate * progress) / np.expm1(-rate)
    return np.where(settling[:, None] == 0, progress, curved)
