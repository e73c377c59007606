"""Joints measured before they have arrived, or that creep on after their reading."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.joints import add_to_joint, joint_column
from robolaser.model.effects.requirements import path

ALIKE = 0.2
"""Spread of the lengths of a joint's moves over their mean, up to which a missing share looks like lost motion."""


def moves(q: Array, run: Run) -> Array:
    """Each joint's last move before each pose, (..., n, j) like the readings q; none before the first of a session."""
    made = np.zeros_like(q)
    for poses in run.paths:
        made[..., poses[1:], :] = q[..., poses[1:], :] - q[..., poses[:-1], :]
    return made


def various_moves(dataset: Dataset) -> str:
    """Some joint has last moves of several lengths."""
    if reason := path(dataset):
        return reason
    alike = "the last moves of each joint all have the same length, so a missing share looks like lost motion"
    return "" if _joints_of_various_moves(dataset) else alike


def _joints_of_various_moves(dataset: Dataset) -> tuple[str, ...]:
    robot, q = dataset.arm
    measured = np.unique(dataset.points.pose) if len(dataset.points) else slice(None)
    lengths = np.abs(moves(q, Run(dataset)))[measured]
    mean = lengths.mean(axis=0)
    alike = (mean > 0.0) & (lengths.std(axis=0) <= ALIKE * mean)
    return tuple(name for name, same in zip(robot.joints, alike, strict=True) if not same)


@final
@dataclass(frozen=True)
class Settling(Effect):
    """A share of the joint's last move is missing: q' = q - share (q - q_before).

    A joint that approaches its goal as exp(-t / τ) and is measured t after the move lacks the share exp(-t / τ); one
    that creeps on after its reading has a share below zero. q_before is the reading of the pose before in time; at the
    first pose of a session nothing is missing.
    """

    name = "settling"
    title = "the joint had not settled: a share of its last move is missing"
    clause = "{where} has not settled when it is measured"
    caveat = "assumes a straight path from the previous pose, and the same wait at each pose"
    remedy = "Wait longer at each pose before measuring, or raise the gain of the servo of {where}."
    reference = "ISO 9283:1998, pose stabilization time and overshoot; 0.01-0.5 % of a move"
    stage = Stage.JOINTS
    cause = "transmission"
    needs = (various_moves,)
    depends_on_trajectory = True

    share: Array = parameter(unit="", bound=0.05, prior_scale=5e-4)

    def apply(self, q: Array, run: Run, /) -> Array:
        column = joint_column(run, self.where)
        missing = self.share[:, None] * moves(q[:, :, [column]], run)[:, :, 0]
        return add_to_joint(q, run, self.where, -missing)

    @classmethod
    def locations(cls, dataset: Dataset) -> tuple[str, ...]:
        every = super().locations(dataset)
        return tuple(joint for joint in every if joint in _joints_of_various_moves(dataset)) if every else ()
