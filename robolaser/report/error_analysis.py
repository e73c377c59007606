"""What a calibration's page and charts are about: errors in millimetres, and what noise alone would make of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly, rows_of_each
from robolaser.model.batches import depends_on_trajectory, with_rows
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.repeats import pixel_repeats
from robolaser.model.noise.sources import error_sources

ENOUGH_ROWS = 20_000  # rows that tell a root mean square to three digits


@final
@dataclass(frozen=True)
class ErrorAnalysis:
    """A calibration with what follows from it."""

    calibration: Calibration

    @cached_property
    def compared(self) -> tuple[Dataset, dict[str, Array]]:
        """The rows of the fit, and their errors, fitted and, where poses were left out, held out, (m', j) [m]."""
        found, of_fit = self.calibration, self.calibration.fitted_model
        fitted = found.errors_m
        if of_fit is not found.model:
            fitted = of_fit.in_metres(found.x, of_fit.residuals(found.x[None])[0])
        errors = {"fitted": fitted} | ({} if found.held_out is None else {"held out": found.held_out})
        return of_fit.dataset, errors

    @cached_property
    def _some(self) -> Model:
        """The model of some rows of each pose, where there are more than a figure about noise needs."""
        model, points = self.calibration.model, self.calibration.model.dataset.points
        if len(points) <= ENOUGH_ROWS or depends_on_trajectory(model):
            return model
        return with_rows(model, rows_of_each(points.pose, max(1, ENOUGH_ROWS // len(model.dataset.poses))))

    @cached_property
    def sources(self) -> tuple[ErrorSource, ...]:
        """What may disturb the rows, for no more rows than a figure needs."""
        return error_sources(self._some, self.calibration.x)

    @cached_property
    def known_noise(self) -> Mapping[str, str]:
        """Sources of noise whose size does not come from the residuals themselves, and where it comes from."""
        known = {source.name: "stated in the data set" for source in self.sources if source.stated is not None}
        if "pixel" not in known and pixel_repeats(self.calibration.model.dataset) is not None:
            known["pixel"] = "from repeats"
        return {name: origin for name, origin in known.items() if name in self.calibration.noise}

    @cached_property
    def noise(self) -> NoiseModel | None:
        """The noise that is known without looking at the residuals, of no more rows than a figure needs; or None."""
        if not self.known_noise:
            return None
        known = {name: self.calibration.noise[name] for name in self.known_noise}
        return NoiseModel(self.sources, {source.name: known.get(source.name, 0.0) for source in self.sources})

    @cached_property
    def noise_m(self) -> float | None:
        """Root-mean-square error that this noise alone would give at the points' places [m]."""
        if self.noise is None:
            return None
        return self.noise.size_m(lambda residuals: self._some.in_metres(self.calibration.x, residuals))


def lengths_mm(errors: Array) -> Array:
    """Lengths of errors (m, j) [m], (m,) [mm]."""
    lengths: Array = 1e3 * np.linalg.norm(errors, axis=-1)
    return lengths


def point_names(dataset: Dataset, rows: Ints) -> tuple[list[str], list[str]]:
    """Names of the poses and of the points of some rows of points.csv."""
    points, poses = dataset.points, dataset.poses
    return [poses.names[points.pose[i]] for i in rows], [points.names[i] for i in rows]


def some_rows(errors: Array, most: int) -> Ints:
    """At most `most` rows for a chart: evenly thinned, the largest tenth of them always among them."""
    if len(errors) <= most:
        return np.arange(len(errors))
    even = evenly(len(errors), most - most // 10)
    largest = np.argsort(errors)[-(most // 10) :]
    return np.unique(np.concatenate([even, largest]))
