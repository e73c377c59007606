"""What each pose says of a joint: the error that an effect is to explain there, and what it leaves."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.gaussian_process_basis import LEAST_TORQUE_NM
from robolaser.diagnosis.stage_derivatives import stage_derivatives
from robolaser.model.effects.effect import CandidateEffect, perturb_with
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.run import Run
from robolaser.model.stages import Stage

BINS: Final = 8
"""Ranges of a coordinate, whose means tell how much of an effect it shows."""
SEEN: Final = 1e-3
"""Share of the usual information on a joint, below which a pose says nothing of it."""


@final
@dataclass(frozen=True, eq=False)
class JointEvidence:
    """An effect of a joint, pose by pose.

    Attributes:
        candidate_effect: Which, and where.
        coordinate: What it depends on most, for a person.
        unit: Of the coordinate: "rad", "Nm", "1" or "".
        x: The coordinate, (n,).
        moves: What the effect adds to the joint, (n,) [rad or m].
        left: What is left of the joint's error beside it, (n,) [rad or m]: the sum is the error without it.
        pose: Which poses these are, (n,).
    """

    candidate_effect: CandidateEffect
    coordinate: str
    unit: str
    x: Array
    moves: Array
    left: Array
    pose: Ints


def joint_evidence(weighed: Weighed) -> Iterator[JointEvidence]:
    """Of each effect that moves a joint by other amounts at other poses."""
    final = weighed.final
    robot = final.model.dataset.robot
    joints = moving_joints(robot)
    values, run, poses = final.problem.parameters.values(final.x[None]), final.model.run, len(final.model.dataset.poses)
    for one in (each.candidate_effect for each in weighed.evidence):
        if one.where not in joints or one.effect.stage_in(final.model.dataset) is not Stage.JOINTS:
            continue
        q = final.model.dataset.arm[1]
        column = run.robot.joints.index(one.where)
        moves = (perturb_with((one.at(values),), run)(Stage.JOINTS, q[None]) - q)[0, :, column]
        if np.ptp(moves) == 0.0:
            continue
        by_joint = stage_derivatives(final).joint(one.where)[:, 0]
        own = np.bincount(final.pose_of_number, by_joint**2, minlength=poses)
        along = np.bincount(final.pose_of_number, by_joint * final.at.white, minlength=poses)
        seen = np.flatnonzero(own > SEEN * np.median(own[own > 0.0]))
        told = max(_coordinates(run, column, one.where), key=lambda each: _shown(each[2][seen], moves[seen]))
        name, unit, x = told
        yield JointEvidence(one, name, unit, x[seen], moves[seen], -along[seen] / own[seen], seen)


def _coordinates(run: Run, column: int, joint: str) -> Iterator[tuple[str, str, Array]]:
    """What an effect of a joint may depend on: words, unit and values."""
    yield f"angle of {joint}", "rad", run.q[:, column]
    if run.robot.has_masses and np.ptp(torque := run.gravity_torques[:, column]) > LEAST_TORQUE_NM:
        yield f"gravity torque at {joint}", "Nm", torque
    if run.poses.time_s is not None:
        yield "share of the run", "", run.progress
        if run.dataset.path_known:
            yield f"direction of approach of {joint}", "1", run.approach[:, column].astype(np.float64)


def _shown(x: Array, moves: Array) -> float:
    """Share of the variance of what an effect does that means over ranges of a coordinate have."""
    ends = np.unique(np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
    bins = np.searchsorted(ends, x, side="right")
    counts = np.maximum(np.bincount(bins), 1)
    means = (np.bincount(bins, moves) / counts)[bins]
    return float(means.var() / moves.var())
