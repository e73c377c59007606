"""Shapes of few parameters outside the library: ramps, hysteresis, two waves a turn, dents.

A dead zone, a step or a corner of a function is a ramp between two knots; friction gives hysteresis, which follows its
cause with play; an oval encoder disc errs twice a turn; a dent in a target is a Gaussian. Each shape costs as little as
an effect, so that one that explains more than an effect is more than an inexact form of it.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.candidate_sites import Site
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.local_unknown import TARGET, joint_equations
from robolaser.diagnosis.localization import function_ratio
from robolaser.diagnosis.pose_coordinates import TIME, angle_of, torque_of
from robolaser.diagnosis.random_functions import RandomFunctions
from robolaser.diagnosis.score_tests import DENSE_GRID
from robolaser.diagnosis.stage_derivatives import stage_derivatives
from robolaser.estimation.noise_estimate import LEVER_M
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.rigid_motion_effect import moments
from robolaser.model.grouped_rows import GroupedRows
from robolaser.model.stages import Stage

DENT_WIDTHS: Final = (0.06, 0.08, 0.1, 0.13, 0.18, 0.25)
"""Standard deviations of dents' Gaussians, over a target's larger side; their spacing is half of it."""


def sparse_shape_chi2(fit: Fit, site: str) -> float:
    """Chi-squared that one of the shapes explains beyond the cost of its choice: at a joint, or in the target.

    For other sites it is a slip of joints, or of the body on the flange, at a moment of the run.

    It is twice the logarithm of the best family's marginal likelihood: all its shapes are equally probable, with normal
    amplitudes whose variance has the largest likelihood.
    """
    dataset = fit.model.dataset
    joints = moving_joints(dataset.robot)
    if site in joints:
        sums = joint_equations(fit, site)
        return max(_ratio(*_along(shapes, *sums)) for shapes in _of_joint(fit, site))
    if site != TARGET:
        return _slip_chi2(fit)
    xyz = dataset.points.xyz
    if xyz is None or not fit.has_optics or stage_derivatives(fit).passing(Stage.TARGET) is None:
        return 0.0
    plane = fit.model.run.target
    sums, levels = _by_height(fit)
    parts = [_along(bells, *sums, levels) for bells in dents((xyz - plane.centre) @ plane.axes[:, :2])]
    return _ratio(*map(np.concatenate, zip(*parts, strict=True)))


def _slip_chi2(fit: Fit) -> float:
    """Chi-squared of a slip of one joint or all, of the body on the flange, or of elastic deflection by a new load."""
    functions, derivatives, run = RandomFunctions(fit), stage_derivatives(fit), fit.model.run
    steps = (run.progress > moments(run)[:, None]).astype(np.float64)
    joints = moving_joints(run.dataset.robot)
    moves = [derivatives.by_motion(Stage.JOINTS, joint) for joint in joints]
    moves += [derivatives.by_motion(Stage.FLANGE) * np.r_[np.ones(3), np.full(3, 1.0 / LEVER_M)]]
    if joints:
        loads = run.loads.torques_of_one_kg[:, [run.robot.joints.index(joint) for joint in joints]]
        together = np.hstack(moves[:-1])
        moves += [together, together * loads[fit.pose_of_number]]
    best = 0.0
    for move in moves:
        slips = (Site("", TIME, move, step[:, None], fit.pose_of_number) for step in steps)
        best = max(best, _mean(np.array([function_ratio(functions, slip) for slip in slips])))
    return best


def _by_height(fit: Fit) -> tuple[tuple[Array, Array, Array], list[tuple[Array, GroupedRows]]]:
    """Normal equations of the target's height at each row, as `normal_equations`; and the terms of shared noise.

    These are a matrix C (m, q) for each level of groups, and the groups of rows: C Cᵀ is subtracted within groups.
    """
    noise, white, Q = fit.noise, fit.at.white, fit.at.Q[: len(fit.at.white)]
    height = np.einsum("qmk,q->mk", stage_derivatives(fit).by_row(Stage.TARGET), fit.model.run.target.axes[:, 2])
    own, levels = noise.precision(height)
    along, *shared = np.einsum("cmk,mk->cm", noise.weigh(np.vstack([white, Q.T])).reshape(-1, *height.shape), height)
    imitated = np.array(shared).T
    return (along - imitated @ (fit.at.Q.T @ fit.at.r), own, imitated), levels


def _of_joint(fit: Fit, joint: str) -> Iterator[Array]:
    """Families of shapes (s, n) of the joint's angle, of its gravity torque, of time."""
    run, time = fit.model.run, fit.model.dataset.poses.time_s
    coordinates = [one.values[:, 0] for one in (angle_of(run, joint), *torque_of(run, joint))]
    yield from map(ramps, coordinates)
    if not run.robot.prismatic[run.robot.joints.index(joint)]:
        yield waves(coordinates[0])
    if time is not None and np.ptp(run.progress) > 0:
        yield ramps(run.progress)
        yield from (plays(coordinate, np.argsort(time, kind="stable")) for coordinate in coordinates)


def ramps(coordinate: Array) -> Array:
    """Functions of a coordinate (n,) that rise by 1 between two knots and are constant elsewhere, (s, n)."""
    knots = np.linspace(coordinate.min(), coordinate.max(), DENSE_GRID)
    first, last = (knots[some][:, None] for some in np.triu_indices(DENSE_GRID, 1))
    return np.asarray(np.clip((coordinate - first) / np.maximum(last - first, 1e-300), 0.0, 1.0) - 0.5)


def waves(angle: Array) -> Array:
    """Functions of an angle (n,) with two periods a turn, as of an oval encoder disc, (s, n)."""
    return np.asarray(np.cos(2.0 * angle - np.linspace(0.0, np.pi, DENSE_GRID, endpoint=False)[:, None]))


def plays(coordinate: Array, order: Ints) -> Array:
    """Functions that follow a coordinate (n,) with play, from pose to pose in order (n,), and their lags, (s, n)."""
    half_width = np.linspace(0.0, 0.5, DENSE_GRID + 1)[1:] * np.ptp(coordinate)
    followed, at = np.empty((DENSE_GRID, len(coordinate))), np.full(DENSE_GRID, coordinate[order[0]])
    for pose in order:
        at = np.clip(at, coordinate[pose] - half_width, coordinate[pose] + half_width)
        followed[:, pose] = at
    return np.vstack([followed - coordinate.mean(), coordinate - followed])


def dents(positions: Array) -> Iterator[Array]:
    """Gaussians over positions on a plane (n, 2), for each width, (s, n)."""
    low, sides = positions.min(axis=0), np.ptp(positions, axis=0)
    for width in max(float(sides.max()), 1e-300) * np.array(DENT_WIDTHS):
        steps = [np.arange(0.0, side + 0.5 * width, 0.5 * width) for side in sides]
        x, y = (np.exp(-0.5 * ((positions[:, i] - low[i] - steps[i][:, None]) / width) ** 2) for i in range(2))
        yield (x[:, None] * y).reshape(-1, len(positions))


def _along(
    shapes: Array, gradient: Array, own: Array, shared: Array, levels: Sequence[tuple[Array, GroupedRows]] = ()
) -> tuple[Array, Array, Array]:
    """Products of shapes (s, n) with the residuals, and their squares, without and with the imitated part, (s,) each.

    They follow from the normal equations of the motions that the shapes describe, see `_by_height`.
    """
    full = shapes**2 @ own
    for C, rows in levels:
        full = full - np.square(np.swapaxes(rows.apart(shapes.T), 1, 2) @ rows.apart(C)).sum(axis=(0, 2))
    return shapes @ gradient, full - ((shapes @ shared) ** 2).sum(axis=1), full


def _ratio(along: Array, squares: Array, full: Array) -> float:
    """Twice the logarithm of the mean likelihood ratio of shapes, from the results of `_along`."""
    z2 = np.maximum(along**2 / np.maximum(squares, NEGLIGIBLE * full), 1.0)
    return _mean(z2 - 1.0 - np.log(z2))


def _mean(ratios: Array) -> float:
    """Twice the logarithm of the mean of likelihood ratios, given as such logarithms; 0 if the mean is below 1."""
    best = float(ratios.max())
    return max(0.0, best + 2.0 * float(np.log(np.exp(0.5 * (ratios - best)).mean())))
