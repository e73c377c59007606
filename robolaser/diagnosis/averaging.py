"""What was seen in each pose, its repeats averaged, gross errors left out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.subsampling import chosen_rows, kept_poses
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel, pixel_from_repeats
from robolaser.model.noise.covariance import FLOOR, noise_from
from robolaser.model.noise.sources import error_sources
from robolaser.model.noise.whitening import group_sums


@final
@dataclass(frozen=True)
class AveragedData:
    """A data set with one row for each point of each pose.

    Attributes:
        dataset: With repeats averaged.
        shots: Rows of points.csv behind each row, (m,).
        group: The row here that each row of points.csv went into, (rows of points.csv,); -1 for gross errors.
    """

    dataset: Dataset
    shots: Ints
    group: Ints

    @classmethod
    def of(cls, dataset: Dataset, outliers: Bools | None = None) -> "AveragedData":
        """Average the repeats of each point, without the rows that are marked as gross errors."""
        points = dataset.points
        kept = np.flatnonzero(~outliers) if outliers is not None else np.arange(len(points))
        if points.repeat is None:
            names: Sequence[object] = kept.tolist()
        else:
            names = list(zip(points.pose[kept].tolist(), (points.names[i] for i in kept), strict=True))
        number = {name: i for i, name in enumerate(dict.fromkeys(names))}
        of_row = np.array([number[name] for name in names], dtype=np.int64)
        shots = np.bincount(of_row)
        first = kept[np.unique(of_row, return_index=True)[1]]

        def mean(values: Array) -> Array:
            return np.asarray(group_sums(values[kept], of_row) / shots[:, None])

        averaged = replace(
            points.take(first),
            repeat=None,
            pixel=None if points.pixel is None else mean(points.pixel),
            xyz=None if points.xyz is None else mean(points.xyz),
            columns={name: mean(values) for name, values in points.columns.items()},
        )
        group = np.full(len(points), -1, dtype=np.int64)
        group[kept] = of_row
        return cls(replace(dataset, points=averaged), shots, group)

    @classmethod
    def single(cls, dataset: Dataset) -> "AveragedData":
        """Each shot a row of its own."""
        rows = np.arange(len(dataset.points), dtype=np.int64)
        return cls(dataset, np.ones_like(rows), rows)

    def subsampled(self) -> "AveragedData":
        """Only rows that say something new; where no path leads through them, only their poses too."""
        kept = chosen_rows(self.dataset)
        if kept.all():
            return self
        number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
        dataset = replace(self.dataset, points=self.dataset.points.take(kept))
        if dataset.poses.time_s is None or not dataset.path_known:
            dataset = dataset.of_poses(kept_poses(dataset))
        return AveragedData(dataset, self.shots[kept], number[self.group])

    def noise(self, model: Model, x: Array, raw: Dataset) -> NoiseModel:
        """The noise of the averaged rows, at x (d,): stated, from repeats, and for what is left from the residuals.

        Errors of whole poses that nobody stated are left out: what the model lacks looks the same, and is what the
        diagnosis is after.

        Args:
            model: Of the averaged data set.
            x: Its parameters.
            raw: The data set with its repeats.
        """
        sources, known = self._sources(model, x, raw)
        if any(source.level != "pose" and known.get(source.name) is None for source in sources):
            J = jacobian_matrix(model, x)
            return noise_without_pose_errors(self._estimated(model, x, J, raw, sources, known))
        return NoiseModel(sources, {source.name: float(known.get(source.name) or 0.0) for source in sources})

    def scatter(self, model: Model, x: Array, J: Array, raw: Dataset) -> NoiseModel:
        """The same with errors of whole poses estimated too, from what columns J (K, n) leave of the residuals."""
        return self._estimated(model, x, J, raw, *self._sources(model, x, raw))

    def _estimated(
        self,
        model: Model,
        x: Array,
        J: Array,
        raw: Dataset,
        sources: tuple[ErrorSource, ...],
        known: Mapping[str, float | None],
    ) -> NoiseModel:
        stated = tuple(replace(source, stated=known.get(source.name)) for source in sources)
        return noise_from(self.dataset, stated, model.residuals(x[None])[0], J)

    def _sources(self, model: Model, x: Array, raw: Dataset) -> tuple[tuple[ErrorSource, ...], dict[str, float | None]]:
        """What may shake the rows, and how much where that is known.

        Where each pose has one row only, a motion of the pose would be the row's error under another name; errors of
        joint readings are not, since what they do depends on the posture.
        """
        every = error_sources(model, x)
        known = {source.name: source.stated for source in every}
        if "pixel" in known and known["pixel"] is None:
            known["pixel"] = pixel_from_repeats(raw)
        alone = np.bincount(self.dataset.points.pose).max() == 1
        share = 1.0 / np.sqrt(self.shots)[:, None, None]
        sources = tuple(
            replace(source, effect=source.effect * share) if source.level == "shot" else source
            for source in every
            if not alone or source.level != "pose" or source.name == "joint" or known.get(source.name) is not None
        )
        return sources, known


def noise_without_pose_errors(noise: NoiseModel) -> NoiseModel:
    """Noise without estimated errors of whole poses, which hold what the model lacks.

    Where rows of a pose fit each other exactly, they were made from one measurement: then they say nothing about its
    errors, and those of whole poses are all that is known. Where each pose has one row, its errors are the row's.
    """
    if all(len(np.unique(source.group)) == len(source.group) for source in noise.sources):
        return noise
    rows = [source.name for source in noise.sources if source.level != "pose"]
    exact = all(name in noise.estimated and noise.sigmas[name] < FLOOR for name in rows)
    return noise if exact else noise.for_weights()
