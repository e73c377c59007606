"""Reflector holders, tools and brackets that slipped on the flange at some moment of the run."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import CarryOver, Run, nonlinear
from robolaser.model.effects.moments import enough_poses, later, moments
from robolaser.model.effects.requirements import passes, pose_order
from robolaser.model.effects.rigid_motion_effect import MountMotion
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.stages import Stage
from robolaser.robot.kinematics import Robot


@final
@dataclass(frozen=True)
class MountShift(MountMotion):
    """After a moment of the run, what the flange carries is shifted, and turned about the flange's origin."""

    name = "mount_shift"
    title = "what the flange carries slipped at a moment of the run"
    clause = "what the flange carries slipped during the run"
    caveat = "a turn about the last joint's axis may be that joint's slip"
    remedy = "Tighten what the flange carries, and measure again."
    reference = "Bickford 2007, Introduction to the Design and Behavior of Bolted Joints, ch. 15: slip; 0.1-2 mm"
    stage = Stage.FLANGE
    cause = "mount"
    needs = (pose_order, enough_poses)
    begins = True

    moment: Array = nonlinear(unit="", lower=0.0, upper=1.0, nominal=0.5)

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

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Each pause between poses with points, (g, 1)."""
        return moments(Run(dataset))[:, None]

    def share(self, run: Run) -> Bools:
        """All of it at the poses that came later."""
        return later(run, self.moment)

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """All poses are after the slip."""
        return CarryOver(self, "the mount is taken as it was after the slip. If it was moved again, calibrate again")
