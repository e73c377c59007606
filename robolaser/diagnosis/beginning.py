"""Where a diagnosis begins: gross errors left out, repeats averaged, the noise known, the sensor's parameters fitted."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.dataset import Dataset
from robolaser.diagnosis.fitted import Fitted, Problem
from robolaser.diagnosis.gross import beyond, gross_rows, robust
from robolaser.diagnosis.observed import Observed
from robolaser.jacobian import jacobian
from robolaser.noise import NoiseModel
from robolaser.parameters import Parameters
from robolaser.scanner import Model

STEPS = 20
"""Of the first fit, which only has to be near."""
SETTLED = 1.1
"""Factor by which noise that is estimated may change without a new search."""


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
        shots = Observed.single(dataset)
        x = sensor.nominal
        noise = shots.noise(model, x, jacobian(model, x), dataset)
        fitted = robust(Problem.of(model, noise, sensor).fit(x, steps=STEPS))
        return cls(dataset, sensor, noise, fitted.x), gross_rows(fitted)

    def fitted(self, gross: Bools, final: Fitted | None = None) -> tuple[Observed, Fitted]:
        """The sensor's parameters fitted to averaged rows without gross errors.

        Args:
            gross: Marks them, (rows of points.csv,).
            final: A model with effects, found before: noise that nobody stated is estimated from what it leaves.
        """
        observed = Observed.of(self.dataset, gross)
        model, x = Model(observed.dataset), self.near
        noise = observed.noise(model, x, jacobian(model, x), self.dataset)
        if final is not None and final.suspects:
            bent = model.with_suspects(final.suspects)
            noise = observed.noise(bent, final.x, jacobian(bent, final.x), self.dataset)
        fitted = Problem.of(model, noise, self.sensor).fit(self.near)
        return observed, fitted

    def settled(self, final: Fitted, gross: Bools) -> bool:
        """Whether what a model with effects leaves speaks for the noise that it was fitted with.

        Args:
            final: The model.
            gross: Rows left out of it, (rows of points.csv,).
        """
        if not final.suspects:
            return True
        model, x, used = final.problem.model, final.x, final.problem.noise
        found = Observed.of(self.dataset, gross).noise(model, x, jacobian(model, x), self.dataset)
        ratio = _size(found) / _size(used)
        return 1.0 / SETTLED < ratio < SETTLED

    def gross(self, final: Fitted) -> Bools:
        """Rows that the final model leaves far off, (rows of points.csv,)."""
        model = Model(self.dataset, final.suspects)
        return beyond(Fitted(Problem.of(model, self.shots, self.sensor), final.x))


def _size(noise: NoiseModel) -> float:
    return float(np.sqrt(np.trace(noise.covariances, axis1=1, axis2=2).mean()))
