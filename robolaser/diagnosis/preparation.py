"""Where a diagnosis begins: gross errors out, repeats averaged, the noise known, the sensor's parameters fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.averaging import Observed, size
from robolaser.diagnosis.outliers import beyond, gross_rows, robust
from robolaser.diagnosis.penalized_fit import Fitted, Problem
from robolaser.diagnosis.pose_noise import explicable
from robolaser.estimation.jacobian import jacobian
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.parameters import Parameters

CALMER = 0.7
"""Share of the scatter taken for granted, below which what an effect leaves of it asks for another look."""
STEPS = 20
"""Of the first fit, which only has to be near."""


@final
@dataclass(frozen=True)
class Beginning:
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
    def of(cls, dataset: Dataset) -> tuple["Beginning", Bools]:
        """Fit robustly to single shots; and mark those that look like gross errors, (rows of points.csv,)."""
        model = Model(dataset)
        sensor = model.parameters
        some = Observed.single(dataset).thinned()
        thin = Model(some.dataset)
        x = sensor.nominal
        noise = some.noise(thin, x, jacobian(thin, x), dataset)
        near = robust(Problem.of(thin, noise, sensor).fit(x, steps=STEPS)).x
        shots = noise
        if len(some.dataset.points) < len(dataset.points):
            sources = tuple(source for source in error_sources(model, near) if source.name in noise.sigmas)
            shots = NoiseModel(sources, noise.sigmas)
        return cls(dataset, sensor, shots, near), gross_rows(Fitted(Problem.of(model, shots, sensor), near))

    def fitted(self, gross: Bools, candidate_effects: Sequence[CandidateEffect]) -> tuple[Observed, Fitted]:
        """The sensor's parameters fitted to averaged rows without gross errors.

        Args:
            gross: Marks them, (rows of points.csv,).
            candidate_effects: Effects that may explain what is left.
        """
        observed = Observed.of(self.dataset, gross).thinned()
        model, x = Model(observed.dataset), self.near
        noise = observed.noise(model, x, jacobian(model, x), self.dataset)
        fitted = Problem.of(model, noise, self.sensor).fit(x)
        if self.dataset.kind == "stripe" or not candidate_effects:
            return observed, fitted
        noise = observed.scatter(model, fitted.x, explicable(fitted, candidate_effects), self.dataset)
        return observed, Problem.of(model, noise, self.sensor).fit(fitted.x)

    def calmer(self, observed: Observed, start: Fitted, final: Fitted) -> Fitted | None:
        """The start judged by the scatter that the final model leaves, where that is far less than was taken for it.

        Of few poses the whole library could explain anything: then what a single effect does passed for scatter.
        """
        if self.dataset.kind == "stripe" or not final.effects:
            return None
        noise = observed.scatter(final.problem.model, final.x, explicable(final, ()), self.dataset)
        if size(noise) > CALMER * size(start.problem.noise):
            return None
        return Problem.of(start.problem.model, noise, self.sensor).fit(start.x)

    def gross(self, final: Fitted) -> Bools:
        """Rows that the final model leaves far off, (rows of points.csv,)."""
        model = Model(self.dataset, final.effects)
        return beyond(Fitted(Problem.of(model, self.shots, self.sensor), final.x))
