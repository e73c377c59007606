"""Fits of models with effects: the problem of `calibrate` with whitened rows and weak priors."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.diagnosis.arm_geometry import marginal_cost, placements_of_arm
from robolaser.diagnosis.profile_likelihood import profile
from robolaser.diagnosis.thresholds import (
    LARGEST_PLAUSIBLE,
    LARGEST_USUAL,
    NO_DIFFERENCE,
    ONE_MEASUREMENT,
    SEARCH_LIMIT,
    SEEN,
)
from robolaser.estimation.identifiability import UNIFORM
from robolaser.estimation.linearization import RANK, TOUCH, Linearization
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE
from robolaser.estimation.outliers import median_length
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import ENOUGH, SHARE, solve
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.sensors.placements import SIX
from robolaser.parameters import Parameters

MOST_STEPS = 20
"""Most steps of a fit, and of estimates of two quantities in turn: a good model takes no more; a hopeless one may creep
along a curved valley, where twenty more lower its error by a per cent."""


def problem_of(model: Model, noise: NoiseModel, sensor: Parameters) -> Problem:
    """The problem that a diagnosis solves.

    Args:
        model: The model with its effects.
        noise: The noise of its rows.
        sensor: The sensor's parameters for all rows, also for a model of some rows.
    """
    parameters = sensor + model.effect_parameters
    return Problem.of(model, noise, prior=usual_sizes(model, parameters), parameters=parameters)


def usual_sizes(model: Model, parameters: Parameters) -> Array:
    """Prior standard deviations of parameters, (d,): that of a uniform distribution in the bounds.

    Nonlinear parameters have no prior: they have no meaning while the others are zero. The prior of a whole arm's
    geometry has its usual size.
    """
    nonlinear = [one.key(each.name) for one in model.effects for each in one.effect.nonlinear_parameters()]
    prior = np.where(np.isin(parameters.names, nonlinear), np.inf, UNIFORM * parameters.width)
    for one in placements_of_arm(model.effects):
        for amplitude in one.effect.amplitudes():
            prior[parameters.names.index(one.key(amplitude.name))] = LARGEST_USUAL * amplitude.prior_scale
    return np.asarray(prior)


@final
@dataclass(frozen=True, eq=False)
class Fit:
    """The optimum of a problem."""

    problem: Problem
    x: Array  # the parameters, (d,)
    slopes: Array | None = None  # derivatives of the whitened residuals there, if known, see `Linearization`, (K, d)

    @classmethod
    def of(cls, problem: Problem, start: Array, slopes: Array | None = None, rival: float = np.inf) -> "Fit":
        """Fit from nearby parameters (d,) and derivatives (d, K), see `solve`."""
        end = solve(problem, start[None], tol=SHARE, enough=ENOUGH, slopes=slopes, rival=rival, most_steps=MOST_STEPS)
        return cls(problem, end.x[0], None if end.slopes is None else end.slopes[0].T)

    @cached_property
    def at(self) -> Linearization:
        """The linearization at the optimum: K whitened numbers of the data, then e of distances and priors."""
        return Linearization(self.problem, self.x, self.slopes)

    @property
    def model(self) -> Model:
        """The model: data and effects."""
        return self.problem.model

    @property
    def noise(self) -> NoiseModel:
        """The noise of the rows."""
        noise = self.problem.noise
        assert noise is not None  # `problem_of` has it
        return noise

    @property
    def sensor(self) -> Parameters:
        """The parameters other than those of effects."""
        every = self.problem.parameters
        return Parameters(every.items[: len(every) - len(self.model.effect_parameters)])

    @property
    def effects(self) -> tuple[CandidateEffect, ...]:
        """The effects in the model."""
        return self.model.effects

    @property
    def has_optics(self) -> bool:
        """Whether the sensor measures pixels: its parameters then imitate much of an arm's geometry.

        Without optics only a few fixed positions are fitted beside the arm, and a pose has few rows.
        """
        return self.model.dataset.points.pixel is not None

    @property
    def chi2(self) -> float:
        """Squared length of the whitened residuals, including those of known distances and priors."""
        return self.at.cost

    @cached_property
    def row_squares(self) -> Array:
        """Squared length of each row's whitened residuals, (m,)."""
        return np.asarray(np.square(self.at.white.reshape(len(self.model.dataset.points), -1)).sum(axis=1))

    @cached_property
    def pose_squares(self) -> Array:
        """Sum of the squared errors of each pose's rows, (n,) [m²]."""
        squares = np.square(self.model.in_metres(self.x, self.at.plain)).sum(axis=1)
        pose, poses = self.model.dataset.points.pose, len(self.model.dataset.poses)
        return np.asarray(np.bincount(pose, squares, minlength=poses), np.float64)

    @cached_property
    def spread(self) -> float:
        """Unevenness of the error over the rows, or over the poses where it is larger, see `spread_of`.

        Poses count by their errors in metres: scatter that was estimated from a few which are far off whitens these.
        """
        numbers, pose = self.model.blocks.row_numbers, self.model.dataset.points.pose
        of_rows = self.noise.at({source.name: 0.0 for source in self.noise.sources_of_poses})
        relative = self.pose_squares * (numbers.mean() / (self.size_of(of_rows) or self.size_of(self.noise)) ** 2)
        there, count = np.unique(pose), np.bincount(pose, numbers).astype(np.int64)
        return max(spread_of(self.row_squares, numbers), spread_of(relative[there], count[there]))

    @cached_property
    def _profile(self) -> tuple[float, float]:
        """Ratio of the likeliest scatter of whole poses to the assumed one, and the change of the deviance by it.

        The sensor's parameters take directions from those that show scatter; effects count by their penalties.
        """
        noise = self.noise
        showing = max(1, int(np.count_nonzero(noise.scatter > SEEN * noise.scatter.max(initial=0.0))))
        share = max(1, showing - len(self.sensor)) / showing
        return profile(noise.scatter_squares(self.at.white), noise.scatter, share)

    @property
    def deviance(self) -> float:
        """Minus twice the logarithm of the likelihood, profiled over the scatter of whole poses.

        It equals `chi2` if the likeliest scatter is the assumed one.
        """
        return self.chi2 + self._profile[1]

    @cached_property
    def with_likeliest_scatter(self) -> "Fit":
        """The same model fitted with the likeliest scatter.

        Weights and scatter are determined in turn: parameters that were fitted with other weights leave more scatter.
        """
        fit = self
        for _ in range(SEARCH_LIMIT):
            factor, _ = fit._profile
            if not len(fit.noise.scatter) or abs(np.log(factor)) < np.log(NO_DIFFERENCE):
                break
            noise = fit.noise.with_scatter_times(factor)
            fit = Fit.of(fit.problem.with_noise(noise), fit.x)
        return fit

    @property
    def freedoms(self) -> int:
        """Degrees of freedom: whitened residuals less parameters, at least 1."""
        return max(1, self.problem.numbers - len(self.x))

    @cached_property
    def poses(self) -> Ints:
        """Numbers of the poses with points."""
        return np.unique(self.model.dataset.points.pose)

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name."""
        return dict(zip(self.problem.parameters.names, self.x.tolist(), strict=True))

    @cached_property
    def deviations(self) -> Array:
        """One standard deviation of each parameter, (d,); zero for fixed ones."""
        return np.sqrt(np.maximum(np.diag(self.at.covariance), 0.0))

    def marginal_cost(self, effects: Sequence[CandidateEffect]) -> float:
        """Cost of the freedom of effects with usual sizes, in chi-squared, without parameters on a bound."""
        own = self._free_parameters(effects)
        prior = self.problem.prior
        assert prior is not None  # `problem_of` has it
        return marginal_cost(self.x[own], self.at.covariance[np.ix_(own, own)], prior[own])

    def wald(self, candidate_effect: CandidateEffect) -> float:
        """Chi-squared of an effect's parameters against zero, without those on a bound.

        Directions of zero covariance, which move no row, contribute nothing.
        """
        own = np.flatnonzero(self._free_parameters([candidate_effect]))
        own = own[self.deviations[own] > 0.0]
        unit, covariance = self.x[own] / self.deviations[own], self.at.covariance[np.ix_(own, own)]
        correlation = covariance / np.outer(self.deviations[own], self.deviations[own])
        return float(unit @ np.linalg.pinv(correlation, rcond=RANK, hermitian=True) @ unit)

    def exceeds_bounds(self, candidate_effect: CandidateEffect) -> bool:
        """Whether a parameter of an effect exceeds its plausible range: an amplitude on a bound, as in a long valley.

        Or a nonlinear parameter that the data push there. Nominal values on a bound do not count, nor do bounds of
        shape parameters, which have no unit, or of a series' further terms.
        """
        kind, problem, near = candidate_effect.effect, self.problem, TOUCH * self.problem.scale
        amplitudes = {one.name: np.logical_or(*self.at.touching) for one in kind.amplitudes()[: len(SIX)]}
        sizes = amplitudes | {one.name: self.at.pushed for one in kind.nonlinear_parameters() if one.unit}
        for item in candidate_effect.parameters.items:
            at, beyond = problem.parameters.names.index(item.name), sizes.get(item.name.rpartition(".")[2])
            if beyond is not None and beyond[at] and abs(self.x[at] - item.nominal) > near[at]:
                return True
        return False

    def is_plausible(self, candidate_effect: CandidateEffect) -> bool:
        """Whether no amplitude of an effect is far larger than usual in industry."""
        sizes = ((self.values[candidate_effect.key(one.name)], one) for one in candidate_effect.effect.amplitudes())
        return all(abs(value) <= LARGEST_PLAUSIBLE * one.prior_scale for value, one in sizes)

    def _free_parameters(self, effects: Sequence[CandidateEffect]) -> Bools:
        keys = [key for one in effects for key in one.parameters.names]
        return np.asarray(np.isin(self.problem.parameters.names, keys) & self.at.free)

    @cached_property
    def pose_of_number(self) -> Ints:
        """The pose of each whitened number of the data, (K,)."""
        return self.model.dataset.points.pose[self.problem.row_of_number]

    def in_metres(self, residuals: Array) -> Array:
        """Residuals (m, k) as errors at the point, (m, j) [m]."""
        return self.model.in_metres(self.x, residuals)

    def size_of(self, noise: NoiseModel) -> float:
        """Root-mean-square 3-D error of a row by noise alone [m]."""
        return noise.size_m(self.in_metres)

    def rotation_of(self, noise: NoiseModel) -> float:
        """Root-mean-square rotation of a row by noise alone [rad]."""
        rows = self.model.dataset.format
        return noise.size_m(lambda residuals: residuals[:, rows.numbers - rows.angles :])

    @cached_property
    def release(self) -> Array:
        """Columns of parameters on a bound, pointing inwards, without the part that the others imitate, (K + e, q)."""
        return self.at.project(self.at.release)

    def best_amplitudes(self, white: Array) -> Array:
        """Amplitudes of further whitened columns (K, n) that lower chi-squared most in the linear model, (n,)."""
        columns = np.hstack([self.at.project(white), self.release])
        return best_amplitudes(columns, self.at.r)[: white.shape[1]]

    def moved(self, white: Array, amplitudes: Array) -> Array:
        """The parameters in the linear model with amplitudes (n,) of further whitened columns (K, n), (d,)."""
        r = self.at.r.copy()
        r[: len(white)] += white @ amplitudes
        return self.x + self.at.step(r)


def spread_of(squares: Array, numbers: Ints) -> float:
    """Ratio of the root mean square of whitened rows to that expected from their median: 1 for normal noise.

    By their squared lengths and numbers of values, (m,) each. It is larger if a part of the rows has most of the error:
    noise estimated from them is no noise of all rows.
    """
    typical = np.median(np.sqrt(squares) / median_length(numbers))
    return float(np.sqrt(squares.sum() / numbers.sum()) / max(typical, ONE_MEASUREMENT))


def best_amplitudes(columns: Array, residuals: Array) -> Array:
    """Amplitudes of columns (k, n) that lower the squares of residuals (k,) most, (n,)."""
    length = np.linalg.norm(columns, axis=0)
    unit = columns / np.where(length > 0, length, 1.0)
    squares, V = np.linalg.eigh(unit.T @ unit)
    seen = squares > NEGLIGIBLE * squares.max(initial=0.0)
    along = V[:, seen].T @ (unit.T @ residuals)
    return np.asarray(-(V[:, seen] @ (along / squares[seen])) / np.where(length > 0, length, 1.0))
