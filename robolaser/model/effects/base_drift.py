"""Bases and measuring systems that creep during the run."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Stage, parameter
from robolaser.model.effects.requirements import no_mount, order_of_its_own
from robolaser.model.effects.rigid_motion_effect import BaseMotion, Creep


@final
@dataclass(frozen=True)
class BaseDrift(Creep, BaseMotion):
    """The flange creeps as `hand_eye_drift` does, but in the base frame.

    A measuring system that creeps looks the same, with the opposite sign. For a sensor on the flange there is
    `hand_eye_drift`.
    """

    name = "base_drift"
    title = "base or measuring system creeps during the run"
    clause = "base or measuring system creeps during the run"
    caveat = "holds for a run like this one; a turn about the first joint's axis may be that joint's drift"
    remedy = "Let the measuring system warm up, clamp the base, and measure some poses again at the end."
    reference = "VDI/VDE 2617-10: drift checks of laser trackers by repeated points; 0.02-1 mm"
    stage = Stage.FLANGE
    cause = "base"
    site = "base"
    needs = (no_mount, order_of_its_own)

    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=5e-4)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=5e-4)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=5e-4)
