"""Bases and measuring systems that creep during the run."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import NOT_WARM, CarryOver, Effect, Run, parameter
from robolaser.model.effects.requirements import no_mount, order_of_its_own
from robolaser.model.effects.rigid_share import about_another, moved_about
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.effects.thermal_state import crept, settling
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class BaseDrift(Effect):
    """The flange creeps as `hand_eye_drift` does, but in the base frame, turned about the middle of all flanges.

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
    depends_on_trajectory = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    turn_x: Array = parameter(unit="rad", bound=0.05, prior_scale=5e-4)
    turn_y: Array = parameter(unit="rad", bound=0.05, prior_scale=5e-4)
    turn_z: Array = parameter(unit="rad", bound=0.05, prior_scale=5e-4)
    settling: Array = settling()

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        """Move the flange on."""
        shift, turn = (self.x, self.y, self.z), (self.turn_x, self.turn_y, self.turn_z)
        middle = run.reference.flange[:, :3, 3].mean(axis=0)
        return moved_about(middle, T_base_flange, shift, turn, crept(run.progress, self.settling))

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It stays as at the end of the run that it was found in, turned about the middle of that."""
        if found_in is None:
            return CarryOver(self, NOT_WARM, alternatives=(None,))
        shift, turn = (self.x, self.y, self.z), (self.turn_x, self.turn_y, self.turn_z)
        middle = run.flange[:, :3, 3].mean(axis=0)
        x, y, z = about_another(np.array(found_in.middle_m), middle, shift, turn)
        return CarryOver(replace(self, x=x, y=y, z=z), NOT_WARM, alternatives=(None,))
