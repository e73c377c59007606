"""Links that grow as the arm warms up."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import pose
from robolaser.model.effects.effect import Run, Stage, parameter
from robolaser.model.effects.joints import joint_column, moving_joints, placed_anew
from robolaser.model.effects.requirements import warm_up
from robolaser.model.effects.thermal_state import NewtonWarming, warmed
from robolaser.robot.kinematics import Robot

SHORTEST_LINK_M = 1e-3


@final
@dataclass(frozen=True)
class ThermalDrift(NewtonWarming):
    r"""The link from the joint before to this one stretches: :math:`p' = p\,(1 + \mathrm{growth}\,g)`.

    g is the measured rise of temperature over its largest (`temperature_c` in the data), else
    :math:`1 - \exp(-\mathrm{progress} / τ)` with τ in shares of the run. Aluminium grows 23e-6 a kelvin, plastics up to
    1e-4: the bound is for plastics 50 K warmer.
    """

    name = "thermal_drift"
    title = "the link before the joint expands as the arm warms up"
    clause = "the link before {where} expands as the arm warms up"
    caveat = "holds for a warm-up like this one"
    remedy = "Let the arm warm up before measuring, or correct for the temperature."
    reference = "Heisel, Richter, Wurst 1997, Thermal behaviour of industrial robots, CIRP Annals 46"
    stage = Stage.LINKS
    cause = "thermal"
    needs = (warm_up,)

    growth: Array = parameter(unit="", bound=5e-3, prior_scale=5e-4, lower=0.0)

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        """Every joint that moves the flange and is at a distance from the joint before."""
        if robot is None:
            return ()
        length = dict(zip(robot.joints, np.linalg.norm(robot.placements[:, :3, 3], axis=-1), strict=True))
        return tuple(joint for joint in moving_joints(robot) if length[joint] > SHORTEST_LINK_M)

    def apply(self, placements: Array, run: Run, /) -> Array:
        column = joint_column(run, self.where)
        strain = self.growth[:, None] * warmed(run, self.tau)
        placement = placements[:, :, column]
        longer = pose(placement[..., :3, :3], placement[..., :3, 3] * (1.0 + strain[..., None]))
        return placed_anew(placements, run, self.where, longer)
