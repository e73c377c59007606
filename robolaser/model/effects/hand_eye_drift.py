"""Brackets that creep or slip during the run, so that the camera moves on the flange."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import NOT_WARM, CarryOver, Run
from robolaser.model.effects.requirements import pose_order
from robolaser.model.effects.rigid_motion_effect import MountMotion
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.effects.thermal_state import crept, settling
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class HandEyeDrift(MountMotion):
    r"""T' = T (exp(g turn), g shift), in the camera's own frame: it turns about its optical centre.

    :math:`g = (1 - e^{-s\,p}) / (1 - e^{-s})` of the run's progress p, where s is `settling`: with 0 the creep is
    even, with a larger one it settles. The amplitudes are the accumulated motion at the end of the run.
    """

    name = "hand_eye_drift"
    title = "the bracket creeps during the run"
    clause = "the sensor's bracket creeps during the run"
    caveat = "holds for a run like this one; a camera whose lens drifts looks nearly the same"
    remedy = "Tighten the sensor's bracket, or calibrate at shorter intervals."
    reference = "Findley, Lai, Onaran 1976, Creep and Relaxation of Nonlinear Viscoelastic Materials"
    stage = Stage.MOUNT
    cause = "mount"
    site = "hand_eye"
    needs = (pose_order,)

    settling: Array = settling()

    def share(self, run: Run) -> Array:
        """Of the creep."""
        return crept(run.progress, self.settling)

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It stays as at the end of the run that it was found in."""
        return CarryOver(self, NOT_WARM, alternatives=(None,))
