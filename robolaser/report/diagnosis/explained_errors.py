"""What each pose or row says of an effect: the error that it is to explain there, and what it leaves."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.subsampling import evenly
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.pose_coordinates import (
    Coordinate,
    angle_of,
    hanging,
    motion_of,
    of_run,
    overturning,
    torque_of,
)
from robolaser.diagnosis.stage_derivatives import stage_derivatives
from robolaser.model.effects.effect import CandidateEffect, perturb_with
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.run import Run
from robolaser.model.stages import OF_ROWS, Stage

BINS: Final = 8
"""Ranges of a coordinate, whose means tell how much of an effect it shows."""
SEEN: Final = 1e-3
"""Share of the usual information on a joint, below which a pose says nothing of it."""
TELLING: Final = 0.5
"""Share of an effect's variance that a coordinate must show; else the error is shown against the effect itself."""
MOST_ROWS: Final = 600
"""That are shown of an effect: more only cover each other."""
ELASTICITY: Final = "elasticity"
"""The class of effects that grow with a load."""
FORESEEN: Final = "error by the effect"
AXES: Final = {1: ("",), 2: (" along u", " along v"), 3: (" along x", " along y", " along z")}
"""Of a row's numbers in metres, in words."""


@final
@dataclass(frozen=True, eq=False)
class ExplainedError:
    """An effect, pose by pose or row by row.

    Attributes:
        candidate_effect: Which, and where.
        coordinate: What it depends on most.
        x: Of it, (n,).
        of: What has the error, for a person.
        unit: Of the error: "rad" or "m".
        moves: The error by the effect, (n,).
        left: What is left beside it, (n,): the sum is the error without it.
        pose: Which poses these are, (n,).
        rival: The most probable effect that may be there instead, and what it leaves, (n,).
    """

    candidate_effect: CandidateEffect
    coordinate: Coordinate
    x: Array
    of: str
    unit: str
    moves: Array
    left: Array
    pose: Ints
    rival: tuple[CandidateEffect, Array] | None


def explained_errors(weighed: Weighed, wanted: Sequence[CandidateEffect]) -> Iterator[ExplainedError]:
    """Of some of the effects that were found."""
    fit = weighed.final
    joints = moving_joints(fit.model.dataset.robot)
    for one in (each for each in weighed.evidence if each.candidate_effect in wanted):
        turns = one.candidate_effect.where in joints
        stage = one.candidate_effect.effect.stage_in(fit.model.dataset)
        yield _of_joint(fit, one) if turns and stage is Stage.JOINTS else _of_rows(fit, one)


def _of_joint(fit: Fit, one: EffectEvidence) -> ExplainedError:
    """As the error of the joint at each pose that tells of it."""
    joint, run, (robot, q) = one.candidate_effect.where, fit.model.run, fit.model.dataset.arm
    column, poses = robot.joints.index(joint), len(q)
    values = fit.problem.parameters.values(fit.x[None])
    moves = (perturb_with((one.candidate_effect.at(values),), run)(Stage.JOINTS, q[None]) - q)[0, :, column]
    by_joint = stage_derivatives(fit).joint(joint)[:, 0]
    own = np.bincount(fit.pose_of_number, by_joint**2, minlength=poses)
    seen = np.flatnonzero(own > SEEN * np.median(own[own > 0.0]))

    def left(other: Fit) -> Array:
        white = fit.noise.whiten(other.model.residuals(other.x[None]))[0]
        along: Array = -np.bincount(fit.pose_of_number, by_joint * white, minlength=poses)[seen] / own[seen]
        return along

    known = (angle_of(run, joint), *torque_of(run, joint), *motion_of(run, joint), *of_run(run))
    coordinate, x = _telling([(each, each.values[seen, 0]) for each in known], moves[seen])
    unit = "m" if robot.prismatic[column] else "rad"
    rival = _rival(one, left)
    return ExplainedError(one.candidate_effect, coordinate, x, joint, unit, moves[seen], left(fit), seen, rival)


def _of_rows(fit: Fit, one: EffectEvidence) -> ExplainedError:
    """As the error of each row in space, along the axis in which the effect moves points most."""
    model, pose = fit.model, fit.model.dataset.points.pose
    others = tuple(each for each in fit.effects if each != one.candidate_effect)
    held = np.isin(fit.problem.parameters.names, one.candidate_effect.parameters.names)
    without = model.with_effects(others).residuals(fit.x[None, ~held])[0]

    def left_by(other: Fit) -> Array:
        in_metres: Array = fit.in_metres(other.model.residuals(other.x[None])[0])
        return in_metres

    left = left_by(fit)
    by_effect = fit.in_metres(without) - left
    axis = int(np.square(by_effect).sum(axis=0).argmax())
    rows = np.arange(len(left))[evenly(len(left), MOST_ROWS)]
    moves = by_effect[rows, axis]
    bends = one.candidate_effect.effect.cause == ELASTICITY
    at_pose = ((each, i) for each in _of_poses(model.run, bends=bends) for i in range(each.values.shape[1]))
    known = [(each, each.values[pose[rows], i]) for each, i in at_pose]
    if one.candidate_effect.effect.stage_in(model.dataset) in OF_ROWS:
        known = [(each, each.values[rows, 0]) for each in _of_points(model.run)] + known
    coordinate, x = _telling(known, moves)
    rival = _rival(one, lambda other: left_by(other)[rows, axis])
    of = f"the points{AXES[left.shape[1]][axis]}"
    return ExplainedError(one.candidate_effect, coordinate, x, of, "m", moves, left[rows, axis], pose[rows], rival)


def _rival(one: EffectEvidence, left: Callable[[Fit], Array]) -> tuple[CandidateEffect, Array] | None:
    """The most probable effect that these data do not distinguish from an effect, and what it leaves."""
    if not one.alternatives:
        return None
    rival, fit = max(one.alternatives, key=lambda pair: one.weights.get(pair[0], 0.0))
    return rival, left(fit)


def _of_poses(run: Run, *, bends: bool) -> Iterator[Coordinate]:
    """What effects on whole poses may depend on; loads for those that bend something."""
    yield from of_run(run)
    for joint in moving_joints(run.dataset.robot):
        yield from (angle_of(run, joint), *(torque_of(run, joint) if bends else ()))
    yield from hanging(run)
    if bends:
        yield from overturning(run)


def _of_points(run: Run) -> Iterator[Coordinate]:
    """What effects on single rows may depend on."""
    pixel, xyz = run.points.pixel, run.points.xyz
    if pixel is not None:
        yield from (Coordinate(f"pixel {name}", pixel[:, [i]], "px") for i, name in enumerate("uv"))
        apart = np.linalg.norm(pixel - pixel.mean(axis=0), axis=1, keepdims=True)
        yield Coordinate("distance from the middle of the image", apart, "px")
    if pixel is not None and xyz is not None:
        yield from (Coordinate(f"place on the target, {name}", xyz[:, [i]], "m") for i, name in enumerate("xy"))


def _telling(known: Sequence[tuple[Coordinate, Array]], moves: Array) -> tuple[Coordinate, Array]:
    """The coordinate that shows most of an effect, and its values."""
    if np.ptp(moves) == 0.0:
        return known[0]
    shown, (coordinate, x) = max(((_shown(x, moves), (one, x)) for one, x in known), key=lambda each: each[0])
    return (coordinate, x) if shown > TELLING else (Coordinate(FORESEEN, moves[:, None], "m"), moves)


def _shown(x: Array, moves: Array) -> float:
    """Share of the variance of what an effect does that means over ranges of a coordinate have."""
    ends = np.unique(np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
    bins = np.searchsorted(ends, x, side="right")
    counts = np.maximum(np.bincount(bins), 1)
    means = (np.bincount(bins, moves) / counts)[bins]
    return float(means.var() / moves.var())
