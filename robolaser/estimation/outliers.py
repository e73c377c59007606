"""Gross errors: rows that no model and no noise explains, found while the model itself may still be wrong."""

from dataclasses import replace
from typing import Final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.estimation.noise_estimate import LEVER_M
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_loss import Loss
from robolaser.estimation.solver import ENOUGH, SHARE, solve
from robolaser.model.blocks.errors import moved_with_pose
from robolaser.model.grouped_rows import group_sums

OUTLIER_SIGMA: Final = 5.5
"""Standard deviations beyond which a row is a gross error. A quantile: noise puts one row of two numbers in four
million there, one of three in a million."""
MIN_POSES: Final = 5
"""Poses with points below which a distance from a model makes no gross error, and no effect is judged: with fewer,
something fits anything. A judgement."""
FREE_POSE_ROWS: Final = 4
"""Fewest rows of a pose that show gross errors beside a free motion of the pose. Geometry: three rows of two numbers
determine the six of a motion."""
FREE_POSE_M: Final = 0.02
"""Standard deviation of whole poses [m], turns as shifts at `LEVER_M`: unmodelled effects move whole poses, gross
errors single rows. A judgement: a nominal arm is off by 10 mm."""
MOST_POSES_OFF: Final = 0.1
"""Share of the poses at which most rows may be gross errors, of all, one sensor or one named point: of more, something
has moved. A judgement."""
FITS = 4  # robust fits, each with the scale of the last one: then the same rows count
ROUNDS = 8  # reweightings of the free motion of a pose
TAIL = 2.385
"""Scale of Cauchy's loss, in standard deviations: 5 % of the efficiency is lost for normal errors along a line, as a
scanner's nearly are; less for errors in all directions."""
MEDIAN = 0.6745  # median length of such errors, in standard deviations
UNUSED = 0.5
"""Numbers of a row less the dimension of its errors, on average: two pixels give a stripe's row three coordinates."""


def robust_fit(problem: Problem, x: Array) -> Array:
    """Parameters (d,) of a robust fit of whitened rows, from near x (d,)."""
    for _ in range(FITS):
        squares = np.add.reduceat(problem.residuals(x[None])[0] ** 2, problem.starts)
        scaled = replace(problem, loss=Loss(max(TAIL * float(np.median(np.sqrt(squares))) / MEDIAN, TAIL)))
        x = solve(scaled, x[None], tol=SHARE, enough=ENOUGH).x[0]
    return x


def outliers_within_poses(problem: Problem, x: Array) -> Bools:
    """Mark rows far from where the others of their pose predict them, by a robust fit x (d,), (m,).

    Each pose may be off as a whole by a free small motion, fitted robustly: so an error of the robot model hides no
    gross error and makes none.
    """
    model = problem.model
    of_pose = model.dataset.points.pose
    root = _roots(problem)
    r = (root @ problem.plain(x[None])[0][..., None])[..., 0]
    enough = np.bincount(of_pose, minlength=len(model.dataset.poses)) >= FREE_POSE_ROWS
    if not enough.any():
        return outliers_of(problem, x)
    shifts, turns = moved_with_pose(model.blocks, *model.at(x))
    moves = FREE_POSE_M * np.concatenate([shifts, turns / LEVER_M], axis=-1)
    B = root @ moves * enough[of_pose, None, None]
    left = r
    for _ in range(ROUNDS):
        scale = _scale(left)
        weight = 1.0 / (1.0 + (np.linalg.norm(left, axis=-1) / (TAIL * scale)) ** 2)
        A = group_sums(weight[:, None, None] * np.swapaxes(B, 1, 2) @ B, of_pose) + scale**2 * np.eye(6)
        b = group_sums(weight[:, None] * (np.swapaxes(B, 1, 2) @ r[..., None])[..., 0], of_pose)
        move = np.linalg.solve(A, b[..., None])[..., 0]
        left = r - (B @ move[of_pose][..., None])[..., 0]
    far = _far(left, model.dataset)
    is_elsewhere = _mostly(far, of_pose)[of_pose] & enough[of_pose]
    return far | is_elsewhere  # the motion fits the pose's other rows, wherever they are


def outliers_of(problem: Problem, x: Array) -> Bools:
    """Mark rows far off a model at x (d,), (m,); none of fewer poses than `MIN_POSES`."""
    of_pose = problem.model.dataset.points.pose
    if len(np.unique(of_pose)) < MIN_POSES:
        return np.zeros(problem.rows, dtype=bool)
    return _far((_roots(problem) @ problem.plain(x[None])[0][..., None])[..., 0], problem.model.dataset)


def _far(rows: Array, dataset: Dataset) -> Bools:
    """Rows (m, k) that are far off; but if most rows of many poses are, the arm or the base has moved.

    So has one of several sensors, or a named point, that is off at many more poses than the others.
    """
    far = np.asarray(np.linalg.norm(rows, axis=-1) > OUTLIER_SIGMA * _scale(rows))
    everything = np.zeros(len(rows), dtype=np.int64)
    moved = _often_off(far, everything, dataset.points.pose, 1)
    for group in (dataset.sensor_of_row, _named_points(dataset)) if far.any() else ():
        moved |= _often_off(far, group, dataset.points.pose, MIN_POSES)
    return far & ~moved


def _often_off(far: Bools, group: Ints, of_pose: Ints, least: int) -> Bools:
    """Rows of poses at which most of their group's are far off, if these poses are too many for gross errors, (m,)."""
    _, first, cell = np.unique(of_pose * (group.max() + 1) + group, return_index=True, return_inverse=True)
    off = _mostly(far, cell)
    often, taken = np.bincount(group[first], off), np.bincount(group[first])
    others = (often.sum() - often) / np.maximum(taken.sum() - taken, 1)
    many = (often >= least) & (often > (MOST_POSES_OFF + others) * taken)
    return np.asarray(off[cell] & many[group])


def _mostly(far: Bools, group: Ints) -> Bools:
    """Whether at least half of the rows (m,) of each group (m,) are far off, (groups,)."""
    return np.asarray(2 * np.bincount(group, far) >= np.bincount(group))


def _named_points(dataset: Dataset) -> Ints:
    """Number of the point of each row, (m,); one for all where names mean different points at different poses."""
    group = np.zeros(len(dataset.points), dtype=np.int64)
    for sensor in dataset.sensors:
        if sensor.data.format.named_points:
            group[sensor.rows] = 1 + dataset.points.number[sensor.rows]
    return group


def _scale(rows: Array) -> float:
    """Standard deviation of white rows (m, k) by their median length, at least 1: gross errors do not move it."""
    numbers = np.array(max(1.0, rows.shape[1] - UNUSED))
    return max(1.0, float(np.median(np.linalg.norm(rows, axis=-1)) / median_length(numbers)))


def median_length(numbers: Array | Ints) -> Array:
    """Median length of rows of so many normal numbers of unit variance each."""
    from scipy.special import chdtri  # noqa: PLC0415 - takes a third of a second to import

    return np.asarray(np.sqrt(chdtri(numbers, 0.5)))


def _roots(problem: Problem) -> Array:
    """Whitens each row by itself, (m, k, k) [1/unit]."""
    assert problem.noise is not None  # rows are judged by their noise
    return np.asarray(np.linalg.inv(np.linalg.cholesky(problem.noise.covariances)))
