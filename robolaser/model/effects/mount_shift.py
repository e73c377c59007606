"""Reflector holders, tools and brackets that slipped on the flange at some moment of the run."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import CarryOver, Effect, Run, nonlinear, parameter
from robolaser.model.effects.moments import enough_poses, later, moments
from robolaser.model.effects.requirements import passes, pose_order
from robolaser.model.effects.rigid_share import moved
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.stages import Stage
from robolaser.robot.kinematics import Robot


@final
@dataclass(frozen=True)
class MountShift(Effect):
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
    depends_on_trajectory = True
    begins = True

    x: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    turn_x: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_y: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
    turn_z: Array = parameter(unit="rad", bound=0.1, prior_scale=2e-3)
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

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        """Move the flange's load in the poses that came later."""
        shift, turn = (self.x, self.y, self.z), (self.turn_x, self.turn_y, self.turn_z)
        return moved(T_base_flange, shift, turn, later(run, self.moment))

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """All poses are after the slip."""
        return CarryOver(self, "the mount is taken as it was after the slip. If it was moved again, calibrate again")
