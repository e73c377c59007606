"""Large data in batches of whole poses: each is independent of the others, so little is kept in memory."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from robolaser.arrays import Ints
from robolaser.data.dataset import Dataset
from robolaser.model.forward_model import Model

ROWS = 6_000
"""Number of rows at which a batch ends: their derivatives by some ten parameters fit a processor's cache."""


def batches_of(model: Model) -> tuple[tuple[Ints, Model], ...]:
    """A model in batches; a single one if it is small, or if an effect depends on more than the pose it changes.

    Returns:
        The numbers of some of its rows, (m,), and the model of only these and their poses, with the parameters of the
        whole.
    """
    whole = np.arange(len(model.dataset.points))
    if len(whole) <= ROWS or depends_on_trajectory(model):
        return ((whole, model),)
    return tuple(_cut(model))


def depends_on_trajectory(model: Model) -> bool:
    """Whether rows of a model depend on poses besides their own."""
    return any(candidate_effect.effect.depends_on_trajectory for candidate_effect in model.effects)


def with_rows(model: Model, rows: Ints) -> Model:
    """The model of some rows; effects that depend on the trajectory see only these and all poses."""
    return of_data(model, replace(model.dataset, points=model.dataset.points.take(rows)))


def of_data(model: Model, dataset: Dataset) -> Model:
    """The model of some of its data, which may be averaged, with the parameters of the whole."""
    return Model(dataset, model.effects, model.course).sharing(model.sensor_parameters)


def _cut(model: Model) -> Iterator[tuple[Ints, Model]]:
    dataset = model.dataset
    order = np.argsort(dataset.points.pose, kind="stable")
    counts = np.bincount(dataset.points.pose, minlength=len(dataset.poses))
    ends = np.cumsum(counts)
    begins = np.searchsorted(ends, np.arange(0, len(order), ROWS), side="right")
    poses = np.unique([*begins, len(counts)])
    for first, last in pairwise(poses.tolist()):
        rows = order[ends[first] - counts[first] : ends[last - 1]]
        if len(rows):
            points = dataset.points.take(rows)
            part = replace(
                dataset,
                poses=dataset.poses.take(np.arange(first, last)),
                points=replace(points, pose=points.pose - first),
            )
            yield rows, Model(part, model.effects).sharing(model.sensor_parameters)
