"""The model's error on poses that it was not fitted to."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import Calibration, rms
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.thresholds import SIGMA_OF_95_PERCENT
from robolaser.estimation.folds import FoldFits, assign_folds, held_out
from robolaser.estimation.noise_weighted_fit import FOLD_ENOUGH, FOLD_SHARE
from robolaser.model.noise.covariance import NoiseModel

RESAMPLES = 2000


@final
class HeldOut:
    """Held-out errors of fits to the same rows, computed once for each.

    With fewer than three poses, of which none can be held out, they are the errors of the fit itself.

    Args:
        start: Any of the fits.
        seed: Assigns poses to folds.
        calibration: Of the model without effects, weighed by noise: of the same rows, its held-out errors are that
            model's, whatever noise was estimated since.
    """

    def __init__(self, start: Fit, seed: int, calibration: Calibration | None = None) -> None:
        self._folds = assign_folds(start.model, seed)
        self._known: dict[Fit, tuple[Array, Array, FoldFits | None]] = {}
        self._calibration = calibration

    def errors(self, fit: Fit) -> Array:
        """Of each row, (m, j) [m]."""
        if fit not in self._known:
            self._known[fit] = self._calibrated(fit) or self._of(fit)
        return self._known[fit][0]

    def _of(self, fit: Fit) -> tuple[Array, Array, FoldFits | None]:
        found = self._folds and held_out(
            fit.problem, fit.x, self._folds, enough=max(FOLD_ENOUGH, FOLD_SHARE * fit.chi2)
        )
        rows = found.errors if found else fit.at.plain
        return fit.in_metres(rows), rows, found

    def unseen(self, fit: Fit) -> FoldFits | None:
        """The fits without each fold, where they were made for this fit."""
        self.errors(fit)
        return self._known[fit][2]

    def _calibrated(self, fit: Fit) -> tuple[Array, Array, FoldFits | None] | None:
        """The calibration's errors, where they are a fit's."""
        known = self._calibration
        if known is None or fit.effects or known.fitted_model.dataset is not fit.model.dataset:
            return None
        in_metres, rows = known.held_out, known.held_out_rows
        return None if in_metres is None or rows is None else (in_metres, rows, known.unseen)

    def turn(self, fit: Fit) -> float:
        """Root mean square of those numbers of the rows that are angles [rad]."""
        self.errors(fit)
        row_format = fit.model.dataset.format
        return rms(self._known[fit][1][:, row_format.numbers - row_format.angles :])

    def gap(self, fit: Fit) -> float:
        """Their root mean square [m]; without effects the calibration's, also where a search left out other rows."""
        known = None if fit.effects or self._calibration is None else self._calibration.held_out_rms_m
        return rms(self.errors(fit)) if known is None else known


def is_lower(before: Array, after: Array, pose: Ints) -> bool:
    """Whether squared errors (m, j) fall by more than chance from pose (m,) to pose would make them."""
    _, number = np.unique(pose, return_inverse=True)
    falls = np.bincount(number, (before**2 - after**2).sum(axis=-1))
    if len(falls) < 2:
        return False
    return bool(falls.mean() > SIGMA_OF_95_PERCENT * falls.std(ddof=1) / np.sqrt(len(falls)))


def expected_gap(fit: Fit, noise: NoiseModel) -> float:
    """The gap that noise alone would leave on held-out poses: noise of rows, and errors of the parameters [m]."""
    rows = fit.at.plain.shape
    moves = fit.noise.correlate(fit.at.Q[: len(fit.at.white)].T).reshape(-1, *rows)
    by_parameters = sum(np.square(fit.in_metres(move)).sum() for move in moves) / rows[0]
    return float(np.sqrt(fit.size_of(noise) ** 2 + by_parameters))


def interval(errors: Array, pose: Ints, seed: int) -> tuple[float, float]:
    """The gap's 95 % interval, by resampling poses [m]."""
    squares = (errors**2).sum(axis=-1)
    seen, number = np.unique(pose, return_inverse=True)
    total, count = np.bincount(number, squares), np.bincount(number)
    drawn = np.random.default_rng(seed).multinomial(len(seen), np.full(len(seen), 1 / len(seen)), RESAMPLES)
    gaps = np.sqrt(drawn @ total / (drawn @ count))
    low, high = np.quantile(gaps, [0.025, 0.975])
    return float(low), float(high)
