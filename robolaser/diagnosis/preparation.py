"""What a diagnosis starts from: gross errors out, repeats averaged, the noise known, the sensor's parameters fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.calibration.checks import check_orientations
from robolaser.calibration.initialization import find_start
from robolaser.calibration.misread_joints import misread_joints
from robolaser.calibration.plan import Plan
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.averaging import AveragedData
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.noise_estimate import PoseNoise, left_by, row_noise, whole_noise
from robolaser.diagnosis.outliers import outliers_of, outliers_within_poses, robust_fit
from robolaser.diagnosis.pose_noise import explainable, explained
from robolaser.diagnosis.pose_scatter import ExcessScatter, pose_scatter
from robolaser.diagnosis.thresholds import IMPLAUSIBLE_NOISE, MIN_POSES, SCATTER_CHANGE
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.parameters import Parameters


@final
@dataclass(frozen=True)
class Preparation:
    """A data set made ready.

    Attributes:
        dataset: As it was given, each shot a row.
        sensor: The sensor's parameters.
        shots: Noise of each shot by itself.
        near: Parameters that fit robustly, while some rows may be gross errors, (d,).
        seed: Chooses the poses that are used, where there are more than needed.
    """

    dataset: Dataset
    sensor: Parameters
    shots: NoiseModel
    near: Array
    seed: int

    @classmethod
    def of(cls, dataset: Dataset, seed: int) -> tuple["Preparation", Bools]:
        """Fit robustly to single shots; and mark those that look like gross errors, (rows of points.csv,).

        The fit starts where that of `calibrate` does.

        Raises:
            EstimationError: The poses cannot say where the sensor sits.
        """
        model = Model(dataset)
        if len(np.unique(dataset.points.pose)) >= MIN_POSES:
            check_orientations(model)
        sensor = model.parameters
        some = AveragedData.single(dataset).subsampled(seed)
        small = Model(some.dataset).sharing(sensor)
        start = find_start(small, Plan(seed=seed)).x
        noise = row_noise(some, small, start, dataset)
        near = robust_fit(Fit.of(problem_of(small, noise, sensor), start)).x
        shots = noise
        if len(some.dataset.points) < len(dataset.points):
            sources = tuple(source for source in error_sources(model, near) if source.name in noise.sigmas)
            shots = NoiseModel(sources, noise.sigmas)
        return cls(dataset, sensor, shots, near, seed), outliers_within_poses(
            Fit(problem_of(model, shots, sensor), near)
        )

    def misread_joints(self, outliers: Bools) -> str | None:
        """A sentence on joints that seem to be read wrongly: no effect is worth a search then; None if none seem so."""
        model = Model(self.dataset).sharing(self.sensor)
        errors = model.in_metres(self.near, model.residuals(self.near[None])[0])[~outliers]
        return misread_joints(model, float(np.sqrt((errors**2).sum(axis=-1).mean())))

    def fit(self, outliers: Bools, effects: Sequence[CandidateEffect]) -> tuple[AveragedData, Fit]:
        """The sensor's parameters fitted to averaged rows without gross errors.

        Args:
            outliers: Marks the gross errors, (rows of points.csv,).
            effects: Effects that may explain what is left.
        """
        data = AveragedData.of(self.dataset, outliers).subsampled(self.seed)
        model, x = Model(data.dataset).sharing(self.sensor), self.near
        noise = row_noise(data, model, x, self.dataset)
        fit = Fit.of(problem_of(model, noise, self.sensor), x)
        if not _scatter_is_seen(fit):
            return data, fit
        noise = whole_noise(data, model, fit.x, explainable(fit, effects), self.dataset)
        return data, Fit.of(problem_of(model, noise, self.sensor), fit.x)

    def with_other_scatter(self, data: AveragedData, start: Fit, final: Fit) -> Fit | None:
        """The start with the noise that the final model leaves, where that is not what was assumed."""
        if not _scatter_is_seen(final):
            return None
        noise = self._noise_of(data, final, smooth=False)
        white = left_by(noise, final.at.plain, jacobian_matrix(final.model, final.x))  # once fitted with its weights
        if white @ white > IMPLAUSIBLE_NOISE * final.problem.numbers:
            return None
        of_poses = 0.5 * (np.log1p(noise.scatter) - np.log1p(start.noise.scatter))
        of_all = np.log(start.size_of(noise) / start.size_of(start.noise))
        if max(np.abs(of_poses).sum() / max(1, len(of_poses)), abs(of_all)) < np.log(SCATTER_CHANGE):
            return None
        return Fit.of(problem_of(start.model, noise, self.sensor), start.x)

    def noise_beside(self, data: AveragedData, final: Fit) -> NoiseModel:
        """The noise that a model leaves beside smooth functions at sites that its residuals speak for.

        For weights and likelihoods all that a model leaves is chance; what is smooth is no noise, though.
        """
        return self._noise_of(data, final, smooth=True) if _scatter_is_seen(final) else final.noise

    def scatter_beside(self, data: AveragedData, final: Fit, *, smooth: bool) -> ExcessScatter | None:
        """Scatter of whole poses beyond what counts as noise; None where there is none, or it cannot be seen.

        Args:
            data: The rows.
            final: The model that leaves it.
            smooth: Whether its residuals speak for smooth functions at some sites: those are no scatter.
        """
        if not _scatter_is_seen(final):
            return None
        columns = explained(final, smooth=smooth)
        return pose_scatter(final, PoseNoise.of(data, final.model, final.x, columns, self.dataset))

    def _noise_of(self, data: AveragedData, final: Fit, *, smooth: bool) -> NoiseModel:
        return whole_noise(data, final.model, final.x, explained(final, smooth=smooth), self.dataset)

    def outliers(self, final: Fit) -> Bools:
        """Rows that the final model leaves far off by the noise that it leaves them, (rows of points.csv,)."""
        model = Model(self.dataset, final.effects).sharing(self.sensor)
        of_rows = {source.name for source in self.shots.sources if source.level != "pose"}
        found = {name: size for name, size in final.noise.sigmas.items() if name in of_rows}
        return outliers_of(Fit(problem_of(model, self.shots.at(found), self.sensor), final.x))


def _scatter_is_seen(fit: Fit) -> bool:
    """Whether the scatter of whole poses can be told from what the sensor's model lacks.

    Not where a camera moves with flange poses of unknown joints: poses that are free in all six ways explain any error
    of a lens or a laser plane, and weights that allow for them trust the model within each pose, where it fails.
    """
    return not fit.has_optics or fit.model.dataset.robot is not None
