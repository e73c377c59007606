"""Brackets that creep or slip during the run, so that the camera moves on the flange."""

from dataclasses import dataclass
from typing import final

from robolaser.model.effects.requirements import pose_order
from robolaser.model.effects.rigid_motion_effect import Creep, MountMotion
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class HandEyeDrift(Creep, MountMotion):
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
