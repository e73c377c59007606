"""The errors of a calibration in millimetres, compared with noise alone, and in sentences."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly, rows_of_each
from robolaser.estimation.noise_estimate import LARGEST_SCATTER, known_sizes
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model, depends_on_trajectory, with_rows
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.report.digits import millimetres, times

ENOUGH_ROWS = 20_000  # rows that determine a root mean square to three digits
WEIGHTING = {"plain": "plain: all points weighted alike", "noise": "points weighted by their noise"}
"""The meaning of a calibration's option `weights`."""
NOISE_ALONE = 1.1  # excess over noise up to which all is well: stated noise is seldom known better
CHANCE = 2.0  # standard errors of the excess that are allowed in addition
UNMODELLED = 2.0  # excess over noise that no uncertainty of the noise explains
OVERFITTED = 1.5  # error on new poses over error on fitted ones, above which there are too many parameters
KNOWN_FROM = {"stated": "stated in the data set", "repeats": "from repeats"}


@final
@dataclass(frozen=True)
class ErrorAnalysis:
    """A calibration with derived quantities."""

    calibration: Calibration

    @cached_property
    def compared(self) -> tuple[Dataset, dict[str, Array]]:
        """The rows of the fit, and their errors: fitted and, where poses were held out, held out, (m', j) [m]."""
        found, of_fit = self.calibration, self.calibration.fitted_model
        fitted = found.errors_m
        if of_fit is not found.model:
            fitted = of_fit.in_metres(found.x, of_fit.residuals(found.x[None])[0])
        errors = {"fitted": fitted} | ({} if found.held_out is None else {"held out": found.held_out})
        return of_fit.dataset, errors

    @cached_property
    def _some(self) -> Model:
        """The model of some rows of each pose, if there are more than noise figures need."""
        model, points = self.calibration.model, self.calibration.model.dataset.points
        if len(points) <= ENOUGH_ROWS or depends_on_trajectory(model):
            return model
        return with_rows(model, rows_of_each(points.pose, max(1, ENOUGH_ROWS // len(model.dataset.poses))))

    @cached_property
    def sources(self) -> tuple[ErrorSource, ...]:
        """Noise sources of the rows, for no more rows than a figure needs."""
        return error_sources(self._some, self.calibration.x)

    @cached_property
    def known_noise(self) -> Mapping[str, str]:
        """Sources of noise whose size is not from the residuals, and its origin."""
        known = known_sizes(self.sources, self.calibration.model.dataset)
        return {name: KNOWN_FROM[origin] for name, (_, origin) in known.items() if name in self.calibration.noise}

    @cached_property
    def noise(self) -> NoiseModel | None:
        """The noise that is known without the residuals, of no more rows than a figure needs; or None."""
        if not self.known_noise:
            return None
        known = {name: self.calibration.noise[name] for name in self.known_noise}
        return NoiseModel(self.sources, {source.name: known.get(source.name, 0.0) for source in self.sources})

    @cached_property
    def noise_m(self) -> float | None:
        """Root-mean-square error at the points by this noise alone [m]."""
        if self.noise is None:
            return None
        return self.noise.size_m(lambda residuals: self._some.in_metres(self.calibration.x, residuals))

    @property
    def headline(self) -> str:
        """Error on new poses, compared with noise alone."""
        calibration, noise = self.calibration, self.noise_m
        does = calibration.model.blocks.sensor.format.task
        if calibration.held_out_rms_m is None:
            first = "The error on new poses is unknown: there are too few poses to hold any out"
        else:
            first = f"On held-out poses, {does} {millimetres(calibration.held_out_rms_m)} off"
        if noise is None:
            return f"{first}; these data do not show how much of that is noise."
        return f"{first}; the known noise alone would give {millimetres(noise)}."

    @property
    def judgement(self) -> str:
        """The conclusion from both figures."""
        calibration, noise = self.calibration, self.noise_m
        error = calibration.held_out_rms_m
        sentences = []
        if calibration.setup_warning is not None:
            sentences.append(calibration.setup_warning)
        elif noise is None:
            sentences.append(
                "State the known noise under `[noise]` in `dataset.toml`: then this report separates it from the errors"
                " of the model."
            )
        elif error is None:
            sentences.append("Measure more poses: the training error is optimistic.")
        else:
            sentences.append(_against_noise(*self.excess(noise), error, error / noise))
        if error is not None and error > OVERFITTED * calibration.rms_m:
            sentences.append(
                f"The error on new poses is {times(error / calibration.rms_m)} times the training error:"
                " the poses are too few or too similar for this many parameters."
            )
        return " ".join(sentences)

    def excess(self, noise_m: float) -> tuple[float, float]:
        """Ratio of the residuals to those that noise leaves in a fit, and its standard error.

        Fitted parameters absorb a part of the noise, for which the degrees of freedom correct; the error on new poses
        is unsuitable here, since few poses raise it even if nothing is unmodelled.
        """
        calibration = self.calibration
        numbers = int(calibration.model.blocks.row_numbers.sum())
        free = max(1, numbers - len(calibration.x) + len(calibration.model.blocks.held))
        ratio = calibration.rms_m / noise_m * float(np.sqrt(numbers / free))
        return ratio, ratio / float(np.sqrt(2 * free))

    @property
    def method(self) -> str:
        """The method of the search."""
        calibration = self.calibration
        return (
            f"{calibration.algorithm}, seed {calibration.seed}, {WEIGHTING[calibration.weights]}; "
            f"{calibration.evaluations:,} candidates in {calibration.seconds:.1f} s"
        )


def _against_noise(over: float, chance: float, error: float, ratio: float) -> str:
    if over <= NOISE_ALONE + CHANCE * chance:
        return "The remaining error is noise: the model is complete for these data."
    if over < UNMODELLED or error < LARGEST_SCATTER["m"]:  # the scatter of poses need not be stated
        return (
            f"That is {times(ratio)} times the known noise. The rest is noise that is not stated, such as the arm's"
            " repeatability, or a small effect that is unmodelled: `robolaser diagnose` distinguishes them."
        )
    return (
        f"That is {times(ratio)} times the known noise: something is unmodelled, and no choice of these parameters"
        " removes it. `robolaser diagnose` finds where it is, and which effects explain it."
    )


def lengths_mm(errors: Array) -> Array:
    """Lengths of errors (m, j) [m], (m,) [mm]."""
    lengths: Array = 1e3 * np.linalg.norm(errors, axis=-1)
    return lengths


def point_names(dataset: Dataset, rows: Ints) -> tuple[list[str], list[str]]:
    """Names of the poses and of the points of some rows of points.csv."""
    points, poses = dataset.points, dataset.poses
    return [poses.names[points.pose[i]] for i in rows], [points.names[i] for i in rows]


def some_rows(errors: Array, most: int) -> Ints:
    """At most `most` rows for a chart: evenly thinned, a tenth of them the largest."""
    if len(errors) <= most:
        return np.arange(len(errors))
    even = evenly(len(errors), most - most // 10)
    largest = np.argsort(errors)[-(most // 10) :]
    return np.unique(np.concatenate([even, largest]))
