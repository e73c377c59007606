"""The fit of rows weighted by their noise: gross errors excluded, repeats averaged, only informative poses."""

from dataclasses import dataclass, replace
from typing import final

from robolaser.arrays import Array, Bools
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.folds import FoldFits, Folds, held_out
from robolaser.estimation.noise_estimate import NoiseEstimate
from robolaser.estimation.outliers import outliers_within_poses, robust_fit
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import ENOUGH, SHARE, solve
from robolaser.model.forward_model import Model, of_data
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources

FOLD_ENOUGH, FOLD_SHARE = 0.1, 1e-4
"""Chi-squared that a fit without one fold may be above its optimum: noise alone moves it by more than 1. Or a share of
it, where a model leaves much."""


@final
@dataclass(frozen=True, eq=False)
class NoiseWeightedFit:
    """Rows with their weights, and the parameters that fit them."""

    data: AveragedData
    outliers: Bools  # marks the gross errors, (rows of points.csv,)
    shots: NoiseModel  # of each row of points.csv, as used for weights
    problem: Problem  # what was minimised
    x: Array  # its optimum, (d,)
    evaluations: int  # residual vectors evaluated

    def held_out(self, folds: Folds) -> FoldFits:
        """Errors on poses held out of the fit."""
        enough = max(FOLD_ENOUGH, FOLD_SHARE * float(self.problem.costs(self.x[None])[0]))
        return held_out(self.problem, self.x, folds, enough=enough)


def fit_by_noise(model: Model, start: Array, *, seed: int) -> NoiseWeightedFit:
    """Fit rows weighted by their noise, from a start (d,).

    Rows far from where the others of their pose predict them are gross errors, judged by a robust fit. The seed
    chooses the poses that are used, where there are more than needed.
    """
    near, shots = _robust(model, start, seed)
    outliers = outliers_within_poses(Problem.of(model, shots), near)
    data = AveragedData.of(model.dataset, outliers).subsampled(seed)
    some = of_data(model, data.dataset)
    problem = Problem.of(some, NoiseEstimate.of(data, some, near).for_weights())
    end = solve(problem.with_rows_of_size(near), near[None], tol=SHARE, enough=ENOUGH)
    problem, x, evaluations = problem.with_rows_of_size(end.x[0]), end.x[0], end.evaluations
    if model.known_distances is not None:
        end = solve(problem, x[None], tol=SHARE, enough=ENOUGH)
        x, evaluations = end.x[0], evaluations + end.evaluations
    return NoiseWeightedFit(data, outliers, shots, problem, x, evaluations)


def _robust(model: Model, start: Array, seed: int) -> tuple[Array, NoiseModel]:
    """Parameters (d,) that fit single shots robustly, and the noise of each of them."""
    few = AveragedData.single(model.dataset).subsampled(seed)
    some = of_data(model, few.dataset)
    noise = NoiseEstimate.of(few, some, start).for_weights()
    near = robust_fit(Problem.of(some, noise).with_rows_of_size(start), start)
    if len(few.dataset.points) == len(model.dataset.points):
        return near, noise
    sources = tuple(source for source in error_sources(model, near) if source.name in noise.sigmas)
    return near, replace(noise, sources=sources)
