"""Robots or targets that were knocked, or moved, at some moment of the run."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import CarryOver, Run, nonlinear, parameter
from robolaser.model.effects.moments import enough_poses, later, moments
from robolaser.model.effects.requirements import pose_order
from robolaser.model.effects.rigid_motion_effect import BaseMotion
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class BaseShift(BaseMotion):
    """After a moment of the run the flange is elsewhere; of several sessions the moment is in one.

    A moved target looks the same, with the opposite sign.
    """

    name = "base_shift"
    title = "robot or target moved at a moment of the run"
    clause = "robot or target was moved during the run"
    caveat = (
        "a moved robot and a moved target look the same: either may have moved; a turn about the first joint's axis may"
        " be that joint's slip"
    )
    remedy = "Find what is loose, clamp base and target, and measure again."
    reference = "Page 1954, Continuous inspection schemes, for steps in a series; cell practice: 0.1-5 mm"
    stage = Stage.FLANGE
    cause = "base"
    site = "base"
    needs = (pose_order, enough_poses)
    begins = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    moment: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=0.5)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Each pause between poses with points, (g, 1)."""
        return moments(Run(dataset))[:, None]

    def share(self, run: Run) -> Bools:
        """All of it at the poses that came later."""
        return later(run, self.moment)

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """All poses are after the shift."""
        doubt = "the cell is taken as it was after the shift. If it was moved again, calibrate again"
        return CarryOver(self.about_middle_of(run, found_in), doubt)
