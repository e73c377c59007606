"""What a diagnosis starts from: gross errors out, repeats averaged, the noise known, the sensor's parameters fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.averaging import AveragedData, noise_size
from robolaser.diagnosis.outliers import outliers_of, outliers_within_poses, robust_fit
from robolaser.diagnosis.penalized_fit import Fit, Problem
from robolaser.diagnosis.pose_noise import explicable
from robolaser.diagnosis.thresholds import SCATTER_REDUCTION
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.parameters import Parameters

STEPS = 20
"""Of the first fit, which only has to be near."""


@final
@dataclass(frozen=True)
class Preparation:
    """A data set made ready.

    Attributes:
        dataset: As it was given, each shot a row.
        sensor: The sensor's parameters.
        shots: Noise of each shot by itself.
        near: Parameters near those that fit, found while some rows may be gross errors, (d,).
    """

    dataset: Dataset
    sensor: Parameters
    shots: NoiseModel
    near: Array

    @classmethod
    def of(cls, dataset: Dataset) -> tuple["Preparation", Bools]:
        """Fit robustly to single shots; and mark those that look like gross errors, (rows of points.csv,)."""
        model = Model(dataset)
        sensor = model.parameters
        some = AveragedData.single(dataset).subsampled()
        small = Model(some.dataset)
        x = sensor.nominal
        noise = some.noise(small, x, jacobian_matrix(small, x), dataset)
        near = robust_fit(Problem.of(small, noise, sensor).fit(x, steps=STEPS)).x
        shots = noise
        if len(some.dataset.points) < len(dataset.points):
            sources = tuple(source for source in error_sources(model, near) if source.name in noise.sigmas)
            shots = NoiseModel(sources, noise.sigmas)
        return cls(dataset, sensor, shots, near), outliers_within_poses(Fit(Problem.of(model, shots, sensor), near))

    def fit(self, outliers: Bools, effects: Sequence[CandidateEffect]) -> tuple[AveragedData, Fit]:
        """The sensor's parameters fitted to averaged rows without gross errors.

        Args:
            outliers: Marks the gross errors, (rows of points.csv,).
            effects: Effects that may explain what is left.
        """
        data = AveragedData.of(self.dataset, outliers).subsampled()
        model, x = Model(data.dataset), self.near
        noise = data.noise(model, x, jacobian_matrix(model, x), self.dataset)
        fit = Problem.of(model, noise, self.sensor).fit(x)
        if self.dataset.kind == "stripe" or not effects:
            return data, fit
        noise = data.scatter(model, fit.x, explicable(fit, effects), self.dataset)
        return data, Problem.of(model, noise, self.sensor).fit(fit.x)

    def with_less_noise(self, data: AveragedData, start: Fit, final: Fit) -> Fit | None:
        """The start with the noise that the final model leaves, where that is far less than was assumed.

        With few poses the whole library could explain anything, and what a single effect does passed for noise.
        """
        if self.dataset.kind == "stripe" or not final.effects:
            return None
        noise = data.scatter(final.problem.model, final.x, explicable(final, ()), self.dataset)
        if noise_size(noise) > SCATTER_REDUCTION * noise_size(start.problem.noise):
            return None
        return Problem.of(start.problem.model, noise, self.sensor).fit(start.x)

    def outliers(self, final: Fit) -> Bools:
        """Rows that the final model leaves far off, (rows of points.csv,)."""
        model = Model(self.dataset, final.effects)
        return outliers_of(Fit(Problem.of(model, self.shots, self.sensor), final.x))
