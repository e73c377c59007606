"""A model's errors on held-out poses."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
from scipy.special import ndtr, stdtrit

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import Calibration, rms
from robolaser.diagnosis.effect_columns import prior_scales
from robolaser.diagnosis.fit import Fit
from robolaser.estimation.certainty import EVEN
from robolaser.estimation.folds import FoldFits, assign_folds, held_out
from robolaser.estimation.noise_weighted_fit import FOLD_ENOUGH, FOLD_SHARE
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE
from robolaser.estimation.problem import Problem
from robolaser.model.noise.covariance import NoiseModel

DRAWS = 2000  # random draws: of resampled poses, and of configurations that may be measured next


@final
@dataclass(frozen=True, eq=False)
class Errors:
    """Held-out errors of one model, with the fits behind them."""

    in_metres: Array  # of the points, (m, j) [m]
    rows: Array  # in the sensor's unit, (m, k)
    folds: FoldFits | None  # the fits without each fold; None if no pose was held out
    x: Array  # the model's parameters, (d,)


@final
class HeldOut:
    """Held-out errors of fits to the same rows, computed once for each.

    With fewer than three poses, of which none can be held out, they are the errors of the fit itself. A model without
    effects is the calibration: its rows have the weights of row noise, whatever scatter of poses was estimated later.

    Args:
        start: Any of the fits.
        seed: Assigns poses to folds.
        calibration: The calibration without effects, weighed by noise; on the same rows, its held-out errors are those
            of the model without effects.
        selected: The model with all selected effects; without it, rotations do not count.
    """

    def __init__(
        self, start: Fit, seed: int, calibration: Calibration | None = None, selected: Fit | None = None
    ) -> None:
        self._folds = assign_folds(start.model, seed)
        self._known: dict[Fit, Errors] = {}
        self._calibration = calibration
        self._start, self._selected = start, selected

    @cached_property
    def _lever(self) -> float:
        """Lever at which the noise of rotations equals that of positions [m].

        0 if the selected effects leave most of the rotations' error: they may only imitate its cause.
        """
        start, selected = self._start, self._selected
        if selected is None or not start.model.dataset.format.angles:
            return 0.0
        before, after = (rms(self.rotation_errors(fit)) for fit in (start, selected))
        if after**2 > EVEN * before**2:
            return 0.0
        return start.size_of(start.noise) / start.rotation_of(start.noise)

    def of(self, fit: Fit) -> Errors:
        """The errors of a fit."""
        if fit not in self._known:
            self._known[fit] = self._computed(fit)
        return self._known[fit]

    def _computed(self, fit: Fit) -> Errors:
        known = self._calibration
        if known is not None and not fit.effects:
            if known.fitted_model.dataset is fit.model.dataset and known.held_out is not None and known.unseen:
                return Errors(known.held_out, known.unseen.errors, known.unseen, known.x)
            fit = Fit.of(fit.problem.with_noise(fit.noise.for_weights()), known.x)
        if self._folds is None:
            return Errors(fit.in_metres(fit.at.plain), fit.at.plain, None, fit.x)
        enough = max(FOLD_ENOUGH, FOLD_SHARE * fit.chi2)
        problem = _with_usual_sizes(fit) if self._folds.whole else fit.problem
        folds = held_out(problem, fit.x, self._folds, enough=enough, slopes=fit.at.slopes.T)
        return Errors(fit.in_metres(folds.errors), folds.errors, folds, fit.x)

    def rotation_errors(self, fit: Fit) -> Array:
        """Errors of the rotations of each row, (m, j) [rad]."""
        row_format = fit.model.dataset.format
        return self.of(fit).rows[:, row_format.numbers - row_format.angles :]

    def gap(self, fit: Fit) -> float:
        """Root-mean-square error of the points [m]."""
        return rms(self.of(fit).in_metres)

    def gap_without(self, fit: Fit) -> float:
        """That of a model from which effects were removed: at most the one without any, as which it can be used."""
        return min(self.gap(fit), self.gap(self._start))

    def _all_errors(self, fit: Fit) -> Array:
        """Errors of each row, (m, j'), including rotations times their lever [m]."""
        return np.hstack([self.of(fit).in_metres, self._lever * self.rotation_errors(fit)])

    def lowers(self, before: Fit, after: Fit) -> bool:
        """Whether the second fit has certainly smaller errors, see `is_lower`."""
        pose = after.model.dataset.points.pose
        return is_lower(self._all_errors(before), self._all_errors(after), pose)

    def misfit(self, fit: Fit) -> float:
        """Root mean square over the rows of all errors, including those of held-out known distances [m].

        An effect must lower it.
        """
        errors = self._all_errors(fit)
        return float(np.sqrt((np.square(errors).sum() + np.square(distance_errors(fit)).sum()) / len(errors)))

    def calibrated(self, start: Fit, final: Fit) -> float:
        """The calibration's gap [m], also where a search excluded other rows.

        Without a calibration it is that of the start. It is also that of a final model without effects, unless that
        excluded further rows: one model has one gap.
        """
        known = self._calibration
        if known is None or known.held_out_rms_m is None:
            return self.gap(start)
        rows, of_calibration = (len(model.dataset.points) for model in (start.model, known.fitted_model))
        return self.gap(start) if not final.effects and rows >= of_calibration else known.held_out_rms_m


def distance_errors(fit: Fit) -> Array:
    """Errors of known distances, each predicted by the poses and the other distances, (e,) [m].

    To first order they are the residuals over one minus their leverages.
    """
    known = fit.model.known_distances
    if known is None:
        return np.empty(0)
    first = len(fit.at.white)
    rows = slice(first, first + len(known))
    left = np.maximum(1.0 - np.square(fit.at.Q[rows]).sum(axis=1), NEGLIGIBLE)
    return np.asarray(known.sigma_m * fit.at.r[rows] / left)


def _with_usual_sizes(fit: Fit) -> Problem:
    """A fit's problem with a prior for each effect, as wide as its fitted parameters.

    Without a whole socket, the others may not determine some of them, as a rotation about the line through two sockets.
    """
    prior = np.full(len(fit.x), np.inf) if fit.problem.prior is None else fit.problem.prior.copy()
    for one in fit.effects:
        scales = prior_scales(one)
        own = [fit.problem.parameters.names.index(name) for name in one.parameters.names[: len(scales)]]
        prior[own] = np.minimum(prior[own], scales * np.sqrt(np.mean((fit.x[own] / scales) ** 2)))
    return replace(fit.problem, prior=prior)


def is_lower(before: Array, after: Array, pose: Ints) -> bool:
    """Whether squared errors (m, j) fall significantly over independent poses (m,), by Student's t."""
    _, number = np.unique(pose, return_inverse=True)
    falls = np.bincount(number, (before**2 - after**2).sum(axis=-1))
    n = len(falls)
    return n > 1 and bool(falls.mean() > stdtrit(n - 1, 0.975) * falls.std(ddof=1) / np.sqrt(n))


def expected_gap(fit: Fit, noise: NoiseModel) -> float:
    """Expected held-out gap of noise alone: noise of rows, and resulting errors of the parameters [m]."""
    rows = fit.at.plain.shape
    moves = fit.noise.correlate(fit.at.Q[: len(fit.at.white)].T).reshape(-1, *rows)
    by_parameters = sum(np.square(fit.in_metres(move)).sum() for move in moves) / rows[0]
    return float(np.sqrt(fit.size_of(noise) ** 2 + by_parameters))


def interval(errors: Array, pose: Ints, seed: int) -> tuple[float, float]:
    """The gap's 95 % interval by resampling poses, with wider quantiles for few poses (Hesterberg 2015) [m]."""
    squares = (errors**2).sum(axis=-1)
    seen, number = np.unique(pose, return_inverse=True)
    total, count = np.bincount(number, squares), np.bincount(number)
    drawn = np.random.default_rng(seed).multinomial(len(seen), np.full(len(seen), 1 / len(seen)), DRAWS)
    gaps = np.sqrt(drawn @ total / (drawn @ count))
    n = len(seen)
    out = ndtr(np.sqrt(n / max(1, n - 1)) * stdtrit(max(1, n - 1), 0.975))
    low, high = np.quantile(gaps, [1.0 - out, out])
    return float(low), float(high)
