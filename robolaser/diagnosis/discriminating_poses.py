"""The poses to measure next: those at which two alternative explanations differ most."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.checks import different_poses
from robolaser.cell.plan_validation import collision_model
from robolaser.data.cell_config import Limits
from robolaser.data.dataset import Dataset, Points
from robolaser.data.joining import stacked
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import DRAWS
from robolaser.estimation.outliers import MIN_POSES
from robolaser.parameters import Values
from robolaser.robot.inverse_kinematics import touching
from robolaser.robot.postures import limits, random_configurations

NEAR_RAD = 0.4
"""Standard deviation of each joint of configurations near a measured one, and least distance of two returned ones in
joint space [rad or m]."""


def too_few_poses(dataset: Dataset) -> str:
    """A sentence if too few poses differ to judge any effect, else ""."""
    different, poses = different_poses(dataset, MIN_POSES), len(np.unique(dataset.points.pose))
    if different >= MIN_POSES:
        return ""
    which = f"All {poses} poses are alike"
    if poses < MIN_POSES:
        which = "Only one pose has points" if poses == 1 else f"Only {poses} poses have points"
    if 1 < different < poses:
        which = f"Only {different} of {poses} poses differ"
    return (
        f"{which}: this is not enough to detect an error, or its cause. Measure {MIN_POSES} or more that differ,"
        " spread over the cell, turned and tilted."
    )


def spread_poses(fit: Fit, *, seed: int) -> tuple[Mapping[str, float], ...]:
    """The next poses without known rivals: those with most information on a fitted model's least certain parameters."""
    scale = fit.problem.scale
    variances, V = np.linalg.eigh(fit.at.covariance / np.outer(scale, scale))
    aside = fit.x + scale * V[:, -1] * np.sqrt(max(float(variances[-1]), 0.0))
    return next_poses(fit, Fit(fit.problem, np.clip(aside, fit.problem.lower, fit.problem.upper)), seed=seed)


def next_poses(one: Fit, other: Fit, *, seed: int) -> tuple[Mapping[str, float], ...]:
    """Find the configurations that distinguish two fitted models best.

    They are within the joint limits, with the target visible and without self-collisions of the arm and its sensor.

    Both models, each with its own best parameters, predict the measurements; a measurement decides most at the largest
    difference in standard deviations of the noise (T-optimality: Atkinson, Fedorov 1975).

    Returns:
        Joint values by name [rad or m], the most discriminating first; none if the sensor has no other poses (sockets)
        or no joint angles were read.
    """
    dataset = one.model.dataset
    robot, q = dataset.robot, dataset.poses.q
    if robot is None or q is None:
        return ()
    rng = np.random.default_rng(seed)
    values = one.problem.parameters.values(one.x[None])
    tried = _aimed(one, values, _configurations(dataset, rng), rng)
    seen = one.model.blocks.seen_from(values, robot.forward(tried[None])[0])
    if seen is None or not seen[1].any():
        return ()
    points, visible = seen
    tried = tried[visible]
    extended, rows = _extended(dataset, tried, points.take(visible[points.pose]))
    difference = _prediction(one, extended)[rows] - _prediction(other, extended)[rows]
    root = np.linalg.inv(np.linalg.cholesky(one.noise.covariances.mean(axis=0)))
    distance = np.nan_to_num(((difference @ root.T) ** 2).sum(axis=(1, 2)))
    chosen: list[int] = []
    bodies = collision_model(dataset, Limits())
    for i in np.argsort(-distance, kind="stable"):
        apart_from_others = all(np.linalg.norm(tried[i] - tried[j]) >= NEAR_RAD for j in chosen)
        if apart_from_others and bodies.clear(tried[[i]])[0]:
            chosen.append(int(i))
        if len(chosen) == MIN_POSES:
            break
    return tuple(dict(zip(robot.joints, tried[i].tolist(), strict=True)) for i in chosen)


def _configurations(dataset: Dataset, rng: np.random.Generator) -> Array:
    """Configurations within the joint limits, with joints that never moved at their constant values, (k, j)."""
    robot, q = dataset.arm
    lower, upper = limits(robot)
    measured = q[np.unique(dataset.points.pose)]
    tried = random_configurations(robot, DRAWS, rng)
    near = measured[rng.integers(len(measured), size=DRAWS // 2)]
    tried[: len(near)] = near + NEAR_RAD * rng.standard_normal(near.shape)
    still = _still(q)
    tried[:, still] = q[0, still]
    return np.asarray(tried[((tried >= lower) & (tried <= upper) | still).all(axis=1)])


def _aimed(fit: Fit, values: Values, tried: Array, rng: np.random.Generator) -> Array:
    """Nearby configurations with something in view; unchanged if the sensor need not aim."""
    robot, q = fit.model.dataset.arm
    aimed = fit.model.blocks.aims(values, robot.forward(q[None])[0])
    if aimed is None:
        return tried
    tools, goals = aimed
    which = rng.integers(len(tools), size=len(tried))
    found, reached = touching(robot, tools[which], goals[which], tried, still=_still(q))
    return found[reached]


def _still(q: Array) -> Bools:
    """Mask of joints that never moved while others did: they are held, (j,)."""
    moved = np.ptp(q, axis=0) > 0
    return np.asarray(~moved & moved.any())


def _prediction(fit: Fit, extended: Dataset) -> Array:
    """Residuals of all rows of an extended data set at a model's parameters, (m, k)."""
    return np.asarray(replace(fit.model, dataset=extended).residuals_at(fit.problem.parameters.values(fit.x[None]))[0])


def _extended(dataset: Dataset, q: Array, seen: Points) -> tuple[Dataset, Ints]:
    """The data set with configurations (k, j) and their points appended; and the rows of each, (k, r).

    They have the time, velocity and temperature of the last pose, and the last session.
    """
    points, poses, n, k = dataset.points, dataset.poses, len(dataset.poses), len(q)
    last = 0 if poses.time_s is None else int(np.argmax(poses.time_s))
    session = None if poses.session is None else (dataset.sessions.names[-1] if dataset.sessions else "",) * k
    new = replace(
        poses.take(np.full(k, last)), names=tuple(f"next {i}" for i in range(k)), q=q, image=None, session=session
    )
    number = np.unique(seen.pose, return_inverse=True)[1]
    longer = replace(dataset, poses=stacked([poses, new]), points=stacked([points, replace(seen, pose=n + number)]))
    return longer, len(points) + np.arange(len(seen)).reshape(k, -1)
