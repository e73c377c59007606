"""Links that grow as the arm warms up."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_robot, no_warming
from robolaser.model.effects.places import joint_column, moving_joints
from robolaser.model.effects.warming import LONGEST, SHORTEST, USUAL, time_constants, warmed
from robolaser.model.stages import Stage

SHORTEST_LINK_M = 1e-3


@final
@dataclass(frozen=True)
class ThermalDrift(Effect):
    r"""The way from the joint before to this one stretches: :math:`p' = p\,(1 + \mathrm{growth}\,g)`.

    g is the measured rise of temperature over its largest (`temperature_c` in the data), else
    :math:`1 - \exp(-\mathrm{progress} / τ)` with τ in shares of the run. Aluminium grows 23e-6 a kelvin.
    """

    name: ClassVar[str] = "thermal_drift"
    title: ClassVar[str] = "the link before the joint grows as the arm warms up"
    reference: ClassVar[str] = "Heisel, Richter, Wurst 1997, Thermal behaviour of industrial robots, CIRP Annals 46"
    stage: ClassVar[Stage] = Stage.LINKS
    depends_on_trajectory: ClassVar[bool] = True

    growth: Array = parameter(unit="", bound=0.02, prior_scale=5e-4)
    tau: Array = shape(unit="", lower=SHORTEST, upper=LONGEST, nominal=USUAL)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Joint angles, and a thermometer or the time."""
        return no_robot(dataset) or no_warming(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """Every joint that moves the flange and is not in one place with the joint before."""
        if cls.missing(dataset) or dataset.robot is None:
            return ()
        length = np.linalg.norm(dataset.robot.placements[:, :3, 3], axis=-1)
        long = {joint for joint, at in zip(dataset.robot.joints, length, strict=True) if at > SHORTEST_LINK_M}
        return tuple(joint for joint in moving_joints(dataset) if joint in long)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Time constants from a twentieth of the run to three runs."""
        return time_constants(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Stretch the joint's placement in each pose."""
        column = joint_column(scene, self.where)
        strain = self.growth[:, None] * warmed(scene, self.tau)
        bent = np.broadcast_to(value, (*strain.shape, *value.shape[2:])).copy()
        bent[:, :, column, :3, 3] *= 1.0 + strain[..., None]
        return bent
