"""Reflector holders and tools that creep during the run."""

from dataclasses import dataclass
from typing import final

from robolaser.model.effects.requirements import no_mount, order_of_its_own
from robolaser.model.effects.rigid_motion_effect import Creep, MountMotion
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class ToolDrift(Creep, MountMotion):
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
