"""Reflector holders and tools that creep during the run."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import NOT_WARM, CarryOver, Effect, Run, parameter
from robolaser.model.effects.requirements import no_mount, order_of_its_own
from robolaser.model.effects.rigid_share import moved
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.effects.thermal_state import crept, settling
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class ToolDrift(Effect):
    """The tool shifts, and turns about the flange's origin, with the creep of `hand_eye_drift`."""

    name = "tool_drift"
    title = "the tool or reflector holder creeps during the run"
    clause = "the tool creeps during the run"
    caveat = "holds for a run like this one"
    remedy = "Tighten what the flange carries, or measure at shorter intervals."
    reference = "Findley, Lai, Onaran 1976, Creep and Relaxation of Nonlinear Viscoelastic Materials"
    stage = Stage.FLANGE
    cause = "mount"
    site = "tool"
    needs = (no_mount, order_of_its_own)
    depends_on_trajectory = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    turn_x: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_y: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_z: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    settling: Array = settling()

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        """Move the tool on."""
        shift, turn = (self.x, self.y, self.z), (self.turn_x, self.turn_y, self.turn_z)
        return moved(T_base_flange, shift, turn, crept(run.progress, self.settling))

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It stays as at the end of the run that it was found in."""
        return CarryOver(self, NOT_WARM, alternatives=(None,))
