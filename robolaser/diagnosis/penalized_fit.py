"""A model with some effects in it, fitted to whitened residuals, and what is left."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.diagnosis.svd_step import Valley
from robolaser.diagnosis.verdict import dispersion
from robolaser.estimation.identifiability import UNIFORM
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.noise import NoiseModel
from robolaser.parameters import Parameters

STEP = 1e-4
"""Of a central difference, as a share of a parameter's scale."""
UPHILL = 1e-6
"""The same of a one-sided difference: small enough that curvature does not show."""
LENGTHS = np.array([0.5, 0.2, 0.05, 0.01])
"""Shares of a Gauss-Newton step that are tried at once."""
PROBE = 0.1
"""Share of a step at which its curvature is measured, for the acceleration along a bent valley (Transtrum, Sethna
2012)."""
BENDS = 0.75
"""Length of the acceleration, relative to the step, up to which it is believed."""
ENOUGH = 0.05
"""A step that promises less of the squared whitened misfit ends the fit: noise alone moves it by more than 1."""
TOUCH = 1e-6
"""Distance from a bound, as a share of what lies between the two, from which on a parameter stands on it."""
MOST_STEPS = 60
SINGULAR = 1e-5
"""Singular values of unit columns below this share of the largest belong to directions that the data do not see."""


@final
@dataclass(frozen=True)
class Problem:
    """Residuals of one set of candidate_effects, whitened, with weak priors, as a function of the parameters.

    Attributes:
        model: With the candidate_effects in it.
        parameters: The model's; the sensor's first.
        prior: Standard deviation by which each parameter may differ from its nominal value, (d,).
        noise: Of the rows.
    """

    model: Model
    parameters: Parameters
    prior: Array
    noise: NoiseModel

    @classmethod
    def of(cls, model: Model, noise: NoiseModel, sensor: Parameters | None = None) -> "Problem":
        """Prepare.

        Args:
            model: With its candidate_effects.
            noise: Of its rows.
            sensor: The sensor's parameters where they are known already: their closed forms cost.
        """
        own = sensor or Model(model.dataset).parameters
        parameters = own + model.effect_parameters
        prior = UNIFORM * parameters.width
        prior[np.isin(parameters.names, model.sensor.fixed)] = 0.0
        return cls(model, parameters, prior, noise)

    @property
    def sensor(self) -> Parameters:
        """The parameters that are no effect's."""
        return Parameters(self.parameters.items[: len(self.parameters) - len(self.model.effect_parameters)])

    @cached_property
    def _is_shape(self) -> Bools:
        names = {
            candidate_effect.key(name)
            for candidate_effect in self.model.effects
            for name, *_ in candidate_effect.effect.nonlinear_parameters()
        }
        return np.isin(self.parameters.names, list(names))

    def within(self, x: Array) -> Array:
        """Candidates (c, d) brought back between their bounds."""
        return np.clip(x, self.parameters.lower, self.parameters.upper)

    def active(self, x: Array, J: Array, r: Array) -> Bools:
        """Parameters on a bound that the misfit would push beyond it, (d,).

        Args:
            x: (d,).
            J: By parameters in units of their priors, (k, d).
            r: (k,).
        """
        uphill = J.T @ r + self.penalty(x[None])[0]
        near = TOUCH * self.parameters.width
        low, high = x <= self.parameters.lower + near, x >= self.parameters.upper - near
        return np.asarray((low & (uphill > 0)) | (high & (uphill < 0)))

    def residuals(self, x: Array) -> Array:
        """Residuals, (c, d) -> (c, m, 3) [m]."""
        return self.model.residuals_at(self.parameters.values(x))

    def __call__(self, x: Array) -> Array:
        """Whitened residuals, (c, d) -> (c, 3m)."""
        return self.noise.whiten(self.residuals(x))

    def derivatives(self, x: Array, of: Callable[[Array], Array]) -> Array:
        """Derivatives of a function of candidates by every parameter that is not held, at x (d,); -> (k, d)."""
        moving = np.flatnonzero(self.prior > 0)
        step = STEP * self.prior[moving]
        ahead = np.repeat(x[None], len(moving), axis=0)
        ahead[np.arange(len(moving)), moving] += step
        behind = 2 * x - ahead
        both = of(np.concatenate([ahead, behind])).reshape(2, len(moving), -1)
        found = np.zeros((both.shape[-1], len(x)))
        found[:, moving] = ((both[0] - both[1]) / (2 * step)[:, None]).T
        return found

    def _uphill(self, x: Array, r: Array, of: Callable[[Array], Array]) -> Array:
        """Derivatives in units of the priors by one-sided differences, which are enough to find the way, (k, d)."""
        moving = np.flatnonzero(self.prior > 0)
        ahead = np.repeat(x[None], len(moving), axis=0)
        ahead[np.arange(len(moving)), moving] += UPHILL * self.prior[moving]
        found = np.zeros((len(r), len(x)))
        found[:, moving] = ((of(ahead) - r) / UPHILL).T
        return found

    def penalty(self, x: Array) -> Array:
        """Distance from the nominal values in units of the prior, (c, d) -> (c, d); shapes may be anything."""
        free = (self.prior > 0) & ~self._is_shape
        return np.where(free, (x - self.parameters.nominal) / np.where(free, self.prior, 1.0), 0.0)

    def fit(self, start: Array, weight: Array | None = None, steps: int = MOST_STEPS) -> "Fit":
        """Gauss-Newton with several lengths and dampings of each step tried at once.

        Args:
            start: (d,).
            weight: Of each whitened residual, (3m,); all alike when absent.
            steps: At most.
        """
        w = 1.0 if weight is None else weight

        def misfit(x: Array) -> Array:
            rows = w * self(x)
            cost = np.einsum("ck,ck->c", rows, rows) + (self.penalty(x) ** 2).sum(axis=1)
            return np.where(np.isfinite(cost), cost, np.inf)

        def rows(x: Array) -> Array:
            return np.hstack([w * self(x), self.penalty(x)])

        x = start
        cost = float(misfit(x[None])[0])
        for _ in range(steps):
            r = rows(x[None])[0]
            J = self._uphill(x, r[: -len(x)], lambda at: w * self(at))
            free = (self.prior > 0) & ~self.active(x, J, r[: len(J)])
            J = np.vstack([J * free, np.diag(free * 1.0)])
            valley = Valley.of(J)
            if valley.promise(r) < ENOUGH:
                break
            first = valley.steps(r)
            perturb = (rows(x + PROBE * self.prior * first) - r - PROBE * first @ J.T) * (2.0 / PROBE**2)
            second = np.stack([valley.steps(row)[i] for i, row in enumerate(np.nan_to_num(perturb))]) / 2.0
            small = np.linalg.norm(second, axis=1) <= BENDS * np.linalg.norm(first, axis=1)
            moves = np.concatenate([first, (first + second)[small], LENGTHS[:, None] * first[0]])
            trials = self.within(x + self.prior * moves)
            costs = misfit(trials)
            best = int(np.argmin(costs))
            if not costs[best] < cost:
                break
            gained = cost - costs[best]
            x, cost = trials[best], float(costs[best])
            if gained < ENOUGH:
                break
        return Fit(self, x)


@final
@dataclass(frozen=True)
class Fit:
    """The optimum of a problem.

    Attributes:
        problem: What was fitted.
        x: The parameters, (d,).
    """

    problem: Problem
    x: Array

    @cached_property
    def residuals(self) -> Array:
        """Residuals, (m, 3) [m]."""
        e: Array = self.problem.residuals(self.x[None])[0]
        return e

    @cached_property
    def white(self) -> Array:
        """Whitened residuals, (3m,)."""
        white: Array = self.problem.noise.whiten(self.residuals[None])[0]
        return white

    @cached_property
    def jacobian(self) -> Array:
        """Plain residuals by parameters, (3m, d) [m per unit]."""
        return self.problem.derivatives(self.x, self.problem.residuals)

    @cached_property
    def J(self) -> Array:  # noqa: N802 - the letter that the field knows it by
        """Whitened residuals by parameters in units of their priors, (3m, d); zero for those stuck on a bound."""
        return self._every * ~self.active

    @cached_property
    def _every(self) -> Array:
        J: Array = self.problem.noise.whiten(self.jacobian.T).T * self.problem.prior
        return J

    @cached_property
    def active(self) -> Bools:
        """Parameters on a bound that the misfit would push beyond it, (d,)."""
        return self.problem.active(self.x, self._every, self.white)

    @cached_property
    def releases(self) -> Array:
        """What those stuck on a bound would do on their way back, what the others can do projected out, (3m + d, q)."""
        middle = (self.problem.parameters.lower + self.problem.parameters.upper) / 2
        ways = np.where(self.x < middle, 1.0, -1.0)[self.active]
        return self.projected(self._every[:, self.active] * ways)

    @cached_property
    def Q(self) -> Array:  # noqa: N802 - likewise
        """Orthonormal basis of what the parameters can do to the residuals, priors beneath, (3m + d, d)."""
        J = np.vstack([self.J, np.eye(len(self.x))])
        Q: Array = np.linalg.qr(J)[0]
        return Q

    @cached_property
    def chi2(self) -> float:
        """Squared whitened misfit, the distance from the priors counted in."""
        return float(self.white @ self.white + (self.problem.penalty(self.x[None]) ** 2).sum())

    @property
    def effects(self) -> tuple[CandidateEffect, ...]:
        """Effects in the model."""
        return self.problem.model.effects

    def projected(self, columns: Array) -> Array:
        """What of whitened columns (3m, k) no parameter can imitate, priors beneath, (3m + d, k)."""
        tall = np.vstack([columns, np.zeros((len(self.x), columns.shape[1]))])
        rest: Array = tall - self.Q @ (self.Q.T @ tall)
        return rest

    @cached_property
    def stacked(self) -> Array:
        """The residuals, priors beneath, (3m + d,); at the optimum no parameter can lower them."""
        return np.concatenate([self.white, self.problem.penalty(self.x[None])[0]])

    def step(self, r: Array) -> Array:
        """What the parameters would do about whitened residuals (3m,), in units of their priors, (d,)."""
        tall = np.concatenate([r, self.problem.penalty(self.x[None])[0]])
        found: Array = -np.linalg.lstsq(np.vstack([self.J, np.eye(len(self.x))]), tall, rcond=None)[0]
        return np.where(self.problem.prior > 0, found, 0.0)

    @property
    def freedoms(self) -> int:
        """Residuals less parameters, at least 1."""
        return max(1, len(self.white) - len(self.x))

    @property
    def dispersion(self) -> float:
        """Factor by which the residuals of whole poses scatter more than noise alone would make them, at least 1."""
        poses = len(np.unique(self.problem.model.dataset.points.pose))
        return dispersion(self.chi2, self.freedoms, poses)

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name."""
        return dict(zip(self.problem.parameters.names, self.x.tolist(), strict=True))

    def best_amplitudes(self, white: Array) -> Array:
        """Amplitudes of further whitened columns (k, n) that lower chi-squared most in the linear model, (n,)."""
        return best_amplitudes(np.hstack([self.projected(white), self.releases]), self.stacked)[: white.shape[1]]

    def value(self, name: str) -> float:
        """A parameter's value."""
        return float(self.x[self.problem.parameters.names.index(name)])

    @cached_property
    def covariance(self) -> Array:
        """Of the parameters, in their units, (d, d)."""
        R = np.linalg.qr(np.vstack([self.J, np.diag((self.problem.prior > 0) * 1.0)]), mode="r")
        inverse = np.linalg.pinv(R)
        found: Array = self.problem.prior[:, None] * (inverse @ inverse.T) * self.problem.prior
        return found


def best_amplitudes(columns: Array, residuals: Array) -> Array:
    """Amplitudes of columns (k, n) that lower the squares of residuals (k,) most, (n,)."""
    length = np.linalg.norm(columns, axis=0)
    length = np.where(length > 0, length, 1.0)
    amplitudes: Array = -np.linalg.lstsq(columns / length, residuals, rcond=SINGULAR)[0] / length
    return amplitudes
