"""The basis of a diagnosis: a calibration weighed by noise, and the noise that candidate effects do not explain."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import final

import numpy as np

from robolaser.arrays import Bools, Ints
from robolaser.calibration.calibrate import calibrated
from robolaser.calibration.checks import check_orientations
from robolaser.calibration.exchanged_poses import belong_there, exchanged, seem_exchanged, with_rows_at
from robolaser.calibration.misread import Misread, misread
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration, rms
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import MAX_POSES
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.pose_noise import explainable, explained
from robolaser.diagnosis.pose_scatter import PartScatter, pose_scatter
from robolaser.diagnosis.thresholds import MOST_RMS_M, NO_DIFFERENCE, NO_NOISE
from robolaser.errors import RobolaserError
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.noise_estimate import NoiseEstimate, left_by
from robolaser.estimation.noise_weighted_fit import NoiseWeightedFit
from robolaser.estimation.outliers import MIN_POSES, outliers_of
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model, jacobian_matrix, of_data
from robolaser.model.noise.covariance import FLOOR, NoiseModel
from robolaser.model.noise.sources import error_sources


@final
@dataclass(frozen=True)
class Preparation:
    """A data set prepared for diagnosis."""

    calibration: Calibration  # of all rows, without effects, weighed by noise
    weighted: NoiseWeightedFit  # the fitted rows, and their weights
    belongs: Mapping[int, int] = field(default_factory=dict)  # right poses of exchanged rows; the calibration uses them

    @classmethod
    def of(cls, dataset: Dataset, seed: int) -> "Preparation":
        """Calibrate, weighed by noise, also with fewer poses than a calibration needs.

        Raises:
            EstimationError: The poses do not determine the sensor's mount.
        """
        if len(np.unique(dataset.points.pose)) >= MIN_POSES:
            check_orientations(Model(dataset))
        found, weighted = _calibrated(dataset, seed)
        if belongs := seem_exchanged(found.model, found.x, found.errors_m):
            corrected, weighted_corrected = _calibrated(with_rows_at(dataset, belongs), seed)
            if belong_there(belongs, found.model, found.errors_m, corrected.errors_m):
                return cls(corrected, weighted_corrected, belongs)
        return cls(found, weighted)

    def misread(self) -> Misread | None:
        """Check for a wrong reading of the files: a search of effects is then useless."""
        return misread(self.calibration.model, self._rms_m)

    @property
    def is_far_off(self) -> bool:
        """Whether errors are too large for any effect of the library."""
        return self._rms_m > MOST_RMS_M

    @property
    def _rms_m(self) -> float:
        return rms(self.calibration.errors_m[~self.weighted.outliers])

    def fit(self, effects: Sequence[CandidateEffect]) -> Fit:
        """Fit the model without effects, with the noise that candidate effects cannot explain."""
        problem, sensor = self.weighted.problem, self.calibration.model.parameters
        assert problem.noise is not None  # rows were weighed by noise
        fit = Fit.of(problem_of(problem.model, problem.noise, sensor), self.weighted.x)
        columns = explainable(fit, effects, poses_scatter=_scatter_is_seen(fit))
        noise = self._noise(NoiseEstimate.of(self.weighted.data, problem.model, fit.x, columns), fit)
        return Fit.of(problem_of(problem.model, noise, sensor), fit.x)

    def without(self, outliers: Bools, fit: Fit, most: int = MAX_POSES) -> tuple[AveragedData, Fit]:
        """Refit a model without gross errors, with unchanged noise.

        Args:
            outliers: Mask of the gross errors, (rows of points.csv,).
            fit: The model.
            most: Approximate number of poses to keep.
        """
        data = AveragedData.of(self.calibration.model.dataset, outliers).subsampled(self.calibration.seed, most)
        model = of_data(self.calibration.model, data.dataset).with_effects(fit.effects)
        noise = fit.noise.of_sources(error_sources(model, fit.x, data.shots))
        return data, Fit.of(problem_of(model, noise, fit.sensor), fit.x)

    def on_all_poses(self, outliers: Ints, final: Fit) -> Fit:
        """Fit a model to all poses, without gross errors (rows of points.csv), if its effects were selected on some."""
        points = self.calibration.model.dataset.points
        if not final.effects or len(np.unique(points.pose)) <= MAX_POSES:
            return final
        left_out = np.isin(np.arange(len(points)), outliers)
        return self.without(left_out, final, most=len(self.calibration.model.dataset.poses))[1]

    def with_other_noise(self, data: AveragedData, start: Fit, final: Fit) -> Fit | None:
        """The start with the noise estimated from the final model; None if it is the assumed one, or too small."""
        noise = self._left(data, final, smooth=False)
        white = left_by(noise, final.at.plain, jacobian_matrix(final.model, final.x))  # after a fit with its weights
        if white @ white > NO_NOISE * final.problem.numbers:
            return None
        of_poses = 0.5 * (np.log1p(noise.scatter) - np.log1p(start.noise.scatter))
        of_all = np.log(start.size_of(noise) / start.size_of(start.noise))
        change = max(np.abs(of_poses).sum() / max(1, len(of_poses)), abs(of_all), _of_rows(noise, start.noise))
        if change < np.log(NO_DIFFERENCE):
            return None
        return Fit.of(problem_of(start.model, noise, self.calibration.model.parameters), start.x)

    def noise_beside(self, data: AveragedData, final: Fit) -> NoiseModel:
        """The remaining noise of a model beside smooth functions at sites with evidence in its residuals.

        Weights and likelihoods treat all residuals as chance; but smooth residuals are no noise.
        """
        return self._left(data, final, smooth=True) if _scatter_is_seen(final) else final.noise

    def scatter_beside(self, data: AveragedData, final: Fit, *, smooth: bool) -> PartScatter | None:
        """Scatter of whole poses beyond noise; None if there is none, or it cannot be distinguished.

        Args:
            data: The rows.
            final: The final model.
            smooth: Whether smooth functions at sites with evidence in the residuals are no scatter.
        """
        if not _scatter_is_seen(final):
            return None
        return pose_scatter(final, _estimate(data, final, smooth=smooth))

    def outliers(self, final: Fit) -> Bools:
        """Mask of gross errors of the final model by its remaining noise, (rows of points.csv,).

        They are gross errors by row noise, and also with scatter of poses, which moves rows of a stretched arm more.
        """
        model = Model(self.calibration.model.dataset, final.effects).sharing(self.calibration.model.sensor_parameters)
        shots, sizes = self.weighted.shots, final.noise.sigmas
        of_rows = {source.name for source in shots.sources if source.level != "pose"}

        def far(names: Collection[str]) -> Bools:
            noise = shots.at({name: size for name, size in sizes.items() if name in names})
            return outliers_of(problem_of(model, noise, final.sensor), final.x)

        found = far(of_rows)
        return found & far({source.name for source in shots.sources}) if found.any() else found

    def _left(self, data: AveragedData, final: Fit, *, smooth: bool) -> NoiseModel:
        return self._noise(_estimate(data, final, smooth=smooth), final)

    def _noise(self, estimate: NoiseEstimate, fit: Fit) -> NoiseModel:
        return estimate.limited if _scatter_is_seen(fit) else estimate.of_rows()


def _calibrated(dataset: Dataset, seed: int) -> tuple[Calibration, NoiseWeightedFit]:
    found = calibrated(Model(dataset), Plan(weights="noise", seed=seed))
    assert found.weighted is not None  # rows were weighed by noise
    return found, found.weighted


@lru_cache(maxsize=1)
def _estimate(data: AveragedData, final: Fit, *, smooth: bool) -> NoiseEstimate:
    """The noise estimated from a model's residuals; that of the last one is cached."""
    return NoiseEstimate.of(data, final.model, final.x, explained(final, smooth=smooth))


def _scatter_is_seen(fit: Fit) -> bool:
    """Whether the scatter of whole poses is distinguishable from errors of the sensor's model.

    It is not for a camera on flange poses of unknown joints: poses with six free motions explain any error of a lens or
    a laser plane, and weights that permit them rely on the model within each pose, where it fails.
    """
    return not fit.has_optics or fit.model.dataset.robot is not None


def _of_rows(noise: NoiseModel, other: NoiseModel) -> float:
    """Largest absolute logarithm of the ratio of a row source's sizes in two noise models."""
    names = [source.name for source in noise.sources if source.level != "pose"]
    sizes = np.array([[max(one.sigmas[name], FLOOR) for name in names] for one in (noise, other)])
    return float(np.abs(np.log(sizes[0] / sizes[1])).max(initial=0.0))


def gross_mistakes(dataset: Dataset) -> tuple[str, ...]:
    """Sentences on errors of centimetres that another reading of the files removes, and on exchanged images.

    No fault is reported if points cannot be calibrated for other reasons.
    """
    try:
        preparation = Preparation.of(dataset, seed=0)
        found, belongs = preparation.misread(), preparation.belongs
    except (RobolaserError, np.linalg.LinAlgError):
        found, belongs = _unfitted(dataset), {}
    sentences = [found.sentence] if found else []
    if belongs:
        sentences.append(f"{exchanged(belongs, dataset.poses.names)}. Correct the data set.")
    return tuple(sentences)


def _unfitted(dataset: Dataset) -> Misread | None:
    try:
        return misread(Model(dataset), np.inf)
    except (RobolaserError, np.linalg.LinAlgError):
        return None
