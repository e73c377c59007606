"""Robots or targets that were knocked, or moved, at some moment of the run."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Stage, parameter
from robolaser.model.effects.rigid_motion_effect import BaseMotion, Shift


@final
@dataclass(frozen=True)
class BaseShift(Shift, BaseMotion):
    """After a moment of the run the flange is elsewhere. A moved target looks the same, with the opposite sign."""

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
    after = "the cell is taken as it was after the shift"

    x: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=1e-3)
    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
