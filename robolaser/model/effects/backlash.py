"""Gears with play: the link lags behind the motor, on the side from which it was pushed."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import CarryOver, Effect, Run, RunSummary, Stage, nonlinear, parameter
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.mechanism import MechanismPart, Play
from robolaser.model.effects.requirements import path

NARROWEST_RAD = 1e-7  # half the play in which a vanishing one is looked at: far above rounding, far below any reading


@final
@dataclass(frozen=True)
class Backlash(Effect):
    """Lost motion: q' is q driven through a play of this width along the path, poses in the order of their time.

    After a move longer than the play, q' = q - lost_motion / 2 in the move's direction; after a shorter one the link
    stays, or is pushed on. The move to the first pose is not known: where in the play the link is there, from one end
    (-1) to the other (1), is a nonlinear parameter.
    """

    name = "backlash"
    title = "lost motion: depends on the direction of approach"
    clause = "{where} has lost motion"
    caveat = "assumes a straight path from the previous pose"
    remedy = "Approach each pose of {where} from the same side, or have its gear adjusted."
    reference = "Nordin, Gutman 2002, Controlling mechanical systems with backlash; 1-2 arcmin, belts 5"
    stage = Stage.JOINTS
    cause = "transmission"
    needs = (path,)
    depends_on_trajectory = True

    lost_motion: Array = parameter(unit="rad", bound=0.02, prior_scale=6e-4, lower=0.0)
    start: Array = nonlinear(unit="", lower=-1.0, upper=1.0, nominal=0.0, tried=(-1.0, 0.0, 1.0))

    def apply(self, q: Array, run: Run, /) -> Array:
        """Drive the joint through the play; with a negative width the link leads."""
        driver, half = q[:, :, joint_column(run, self.where)], np.maximum(np.abs(self.lost_motion) / 2, NARROWEST_RAD)
        ahead = np.concatenate([play(driver[:, poses], half * self.start, half) for poses in run.paths], axis=1)
        share = ahead[:, np.argsort(np.concatenate(run.paths))] / half[:, None]
        return add_to_joint(q, run, self.where, self.lost_motion[:, None] / 2 * share)

    def parts(self, run: Run) -> tuple[MechanismPart, ...]:
        """Play behind the joint, held by twice the friction that its weight needs; none where the link leads."""
        column = joint_column(run, self.where)
        friction = 1.0 + 2.0 * float(np.abs(run.loads.gravity_torques[:, column]).max())
        width = float(self.lost_motion[0])
        return (Play(self.where, width, friction),) if width > 0 else ()

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It follows the path of the other run; where in the play its first pose is stays unknown."""
        if reason := self.hindrance(run):
            off = (JointOffset(self.where, sign * self.lost_motion / 2) for sign in (-1, 1))
            return CarryOver(None, reason, alternatives=tuple(off))
        ends = (replace(self, start=np.array([end])) for end in (-1.0, 1.0))
        return CarryOver(
            replace(self, start=np.zeros(1)),
            "until the joint has reversed, its position within its play is not known",
            alternatives=tuple(ends),
        )


def play(driver: Array, ahead: Array, half: Array) -> Array:
    """A play operator: the driven side lags by half the play, and follows only when pushed.

    Each pose clips the link's position to the play around its driver, and successive clips are one clip: so all poses
    are found in as many rounds as their number has binary digits.

    Args:
        driver: Position of the driving side at every pose, (c or 1, n).
        ahead: Of the driven side at the first pose, (c,), within the play.
        half: Half the play, (c,), not negative.

    Returns:
        How far the driven side is ahead of the driving one at every pose, (c, n).

    Source: Krasnoselskii, Pokrovskii 1989, Systems with Hysteresis.
    """
    first = driver[:, :1] + ahead[:, None]
    low, high = (np.concatenate([first, driver[:, 1:] + side[:, None]], axis=1) for side in (-half, half))
    reach = 1
    while reach < driver.shape[1]:
        before, after = slice(None, -reach), slice(reach, None)
        ends = [np.clip(end[:, before], low[:, after], high[:, after]) for end in (low, high)]
        low, high = (np.concatenate([end[:, :reach], on], axis=1) for end, on in zip((low, high), ends, strict=True))
        reach *= 2
    return low - driver
