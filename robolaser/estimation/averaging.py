"""The points of each pose, repeats averaged, gross errors excluded."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import MAX_POSES, chosen_rows, kept_poses
from robolaser.model.grouped_rows import group_sums


@final
@dataclass(frozen=True, eq=False)
class AveragedData:
    """A data set with one row for each point of each pose."""

    raw: Dataset  # as measured, each shot a row
    dataset: Dataset  # with repeats averaged
    shots: Ints  # rows of points.csv behind each row, (m,)
    group: Ints  # the row here that each row of points.csv went into, (rows of points.csv,); -1 for gross errors

    @classmethod
    def of(cls, dataset: Dataset, outliers: Bools | None = None) -> "AveragedData":
        """Average the repeats of each point, without the rows that are marked as gross errors."""
        points = dataset.points
        kept = np.flatnonzero(~outliers) if outliers is not None else np.arange(len(points))
        many = np.array([sensor.data.format.many_rows for sensor in dataset.sensors])[dataset.sensor_of_row]
        if points.repeat is None or many.all():
            names: Sequence[object] = kept.tolist()
        else:
            pose = points.pose.tolist()
            names = [i if many[i] else (pose[i], points.names[i]) for i in kept.tolist()]
        number = {name: i for i, name in enumerate(dict.fromkeys(names))}
        of_row = np.array([number[name] for name in names], dtype=np.int64)
        shots = np.bincount(of_row)
        first = kept[np.unique(of_row, return_index=True)[1]]

        def mean(values: Array) -> Array:
            return np.asarray(group_sums(values[kept], of_row) / shots[:, None])

        means = {
            name: mean(_of_one_sign(values, points.place) if name == "quaternion" else values)
            for name, values in points.arrays.items()
        }
        averaged = replace(points.take(first), repeat=None).with_arrays(means)
        group = np.full(len(points), -1, dtype=np.int64)
        group[kept] = of_row
        whole = dataset.whole if len(shots) == len(points) else dataset.whole or dataset
        return cls(dataset, replace(dataset, points=averaged, whole=whole), shots, group)

    @classmethod
    def single(cls, dataset: Dataset) -> "AveragedData":
        """Each shot a row of its own."""
        rows = np.arange(len(dataset.points), dtype=np.int64)
        return cls(dataset, dataset, np.ones_like(rows), rows)

    def subsampled(self, seed: int, most: int = MAX_POSES) -> "AveragedData":
        """Only rows with new information, of about so many poses; the seed chooses among poses that are alike.

        Without a known path through the poses, only their poses too.
        """
        kept = chosen_rows(self.dataset, seed, most)
        if kept.all():
            return self
        number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
        dataset = replace(self.dataset, points=self.dataset.points.take(kept), whole=self.raw.whole or self.raw)
        if dataset.poses.time_s is None or not dataset.path_known:
            dataset = dataset.of_poses(kept_poses(dataset))
        return replace(self, dataset=dataset, shots=self.shots[kept], group=number[self.group])


def _of_one_sign(quaternions: Array, group: Ints) -> Array:
    """Quaternions (m, 4), in one group all near its first, where q and −q are one rotation."""
    first = np.unique(group, return_index=True)[1][group]
    along = (quaternions * quaternions[first]).sum(axis=1, keepdims=True)
    return np.asarray(np.where(along < 0.0, -quaternions, quaternions))
