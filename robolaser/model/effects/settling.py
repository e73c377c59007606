"""Joints that are measured before they have arrived, or that creep on after they were read."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, parameter
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.requirements import path
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class Settling(Effect):
    """A share of the joint's last move is missing: q' = q - share (q - q_before).

    A joint that approaches its goal as exp(-t / τ) and is measured t after the move lacks the share exp(-t / τ); one
    that creeps on after its reading has a share below zero. q_before is the reading of the pose before in time; at the
    first pose of a session nothing is missing.
    """

    name = "settling"
    title = "the reading is older or younger than the measurement: a share of the joint's last move is missing"
    clause = "{where} has not settled when it is measured"
    caveat = "assumes that the arm came straight from the pose before, and waited as long at each pose"
    remedy = "Wait longer at each pose before measuring, or raise the gain of the servo of {where}."
    reference = "ISO 9283:1998, pose stabilization time and overshoot; 0.01-0.5 % of a move"
    stage = Stage.JOINTS
    cause = "transmission"
    needs = (path,)
    depends_on_trajectory = True

    share: Array = parameter(unit="", bound=0.05, prior_scale=5e-4)

    def apply(self, q: Array, run: Run, /) -> Array:
        """Hold back a share of each move."""
        column = joint_column(run, self.where)
        moves = np.zeros(q.shape[:2])
        for poses in run.paths:
            readings = q[:, poses, column]
            moves[:, poses] = np.diff(readings, axis=1, prepend=readings[:, :1])
        return add_to_joint(q, run, self.where, -self.share[:, None] * moves)
