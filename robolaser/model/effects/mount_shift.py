"""Reflector holders, tools and brackets that slipped on the flange at some moment of the run."""

from dataclasses import dataclass
from typing import final

from robolaser.data.dataset import Dataset
from robolaser.model.effects.requirements import passes
from robolaser.model.effects.rigid_motion_effect import MountMotion, Shift
from robolaser.model.stages import Stage
from robolaser.robot.kinematics import Robot


@final
@dataclass(frozen=True)
class MountShift(Shift, MountMotion):
    """After a moment of the run, what the flange carries is shifted, and turned about the flange's origin."""

    name = "mount_shift"
    title = "what the flange carries slipped at a moment of the run"
    clause = "what the flange carries slipped during the run"
    caveat = "a turn about the last joint's axis may be that joint's slip"
    remedy = "Tighten what the flange carries, and measure again."
    reference = "Bickford 2007, Introduction to the Design and Behavior of Bolted Joints, ch. 15: slip; 0.1-2 mm"
    stage = Stage.FLANGE
    cause = "mount"
    after = "the mount is taken as it was after the slip"

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        """A sensor's bracket, or what carries the reflectors."""
        return "hand_eye", "tool"

    @classmethod
    def locations(cls, dataset: Dataset) -> tuple[str, ...]:
        """The bracket where the flange carries a sensor."""
        if cls.missing(dataset):
            return ()
        return ("tool",) if passes(Stage.MOUNT, dataset) else ("hand_eye",)
