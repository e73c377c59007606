"""Rows that are one pose off from some pose on: a pose, or an image, was lost there or counted twice."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.other_readings import FEWEST_POSES, ROWS, SHIFTS, Hypothesis, with_rows_moved
from robolaser.calibration.result import rms_of_poses
from robolaser.data.dataset import Dataset
from robolaser.errors import RobolaserError
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import after, solve
from robolaser.model.batches import of_data
from robolaser.model.forward_model import Model

STEPS = 12  # of each descent; an error that has not fallen by then is no sign
COARSE = 1e-6


def short_fit(dataset: Dataset) -> tuple[Model, Array] | None:
    """The model without effects, and its parameters (d,) a few steps from its own start; None where there is none."""
    try:
        model = Model(dataset)
        start = model.fix_gauge(model.parameters.nominal)
        return model, solve(Problem.of(model), start[None], tol=COARSE, hopeless=after(STEPS)).x[0]
    except (RobolaserError, np.linalg.LinAlgError):
        return None


def slipped(dataset: Dataset) -> Iterator[Hypothesis]:
    """The rows from some pose on at the pose after theirs, and before.

    The first third of the poses is fitted as it is read, and the last third where it then belongs: one of the two is
    on one side of the slip. By either fit the slip is where it makes the errors of all poses smallest.

    Args:
        dataset: With poses in the order in which they were measured.
    """
    poses = np.unique(dataset.points.pose)
    if len(poses) < 3 * FEWEST_POSES or _names_differ(dataset, poses):
        return
    third = len(poses) // 3
    of_first = short_fit(_of(dataset, poses[:third]))
    for shift, which in SHIFTS.items():
        moved = with_rows_moved(dataset, shift)
        fits = of_first, short_fit(_of(moved, poses[-third:] + shift))
        found = [_likeliest(dataset, moved, shift, *fit) for fit in fits if fit is not None]
        gain, first = max(found, default=(0.0, 0))
        if gain > 0.0 and first > poses[0]:
            name = dataset.poses.names[first]
            fault = f"From pose {name} on, the points, or images, seem to belong to the pose {which} theirs"
            yield Hypothesis(with_rows_moved(dataset, shift, first), fault, ROWS, shift)


def _of(dataset: Dataset, poses: Ints) -> Dataset:
    return replace(dataset, points=dataset.points.take(np.flatnonzero(np.isin(dataset.points.pose, poses))))


def _names_differ(dataset: Dataset, poses: Ints) -> bool:
    """Whether a third of the poses shows other points than all do: what stands where is then not found from it."""
    third = len(poses) // 3
    ends = (_of(dataset, some).points.names for some in (poses[:third], poses[-third:]))
    return any(set(names) != set(dataset.points.names) for names in ends)


def _likeliest(as_read: Dataset, moved: Dataset, shift: int, model: Model, x: Array) -> tuple[float, int]:
    """By how much a slip shrinks the errors, as a sum of logarithms over the poses, and the first pose behind it."""
    count = len(as_read.poses)
    here, there = (_errors(of_data(model, each), x, count) for each in (as_read, moved))
    ratio = np.nan_to_num(np.log(here) - np.log(np.roll(there, -shift)))
    gains = np.cumsum(ratio[::-1])[::-1]
    return float(gains.max()), int(np.argmax(gains))


def _errors(model: Model, x: Array, count: int) -> Array:
    return rms_of_poses(model.in_metres(x, model.residuals(x[None])[0]), model.dataset.points.pose, count)
