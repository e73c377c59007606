"""The Fisher information of a fit's rows about its parameters, one batch of rows at a time."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.estimation.linearization import triangle
from robolaser.estimation.problem import Problem
from robolaser.model.forward_model import Model, jacobian
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources, shared_by_rows

UNMOVED = 1e-10
"""[row's unit] A parameter whose whole range moves every row by less than this changes nothing but rounding errors, as
the moment of a `base_shift` does between two poses."""


@final
@dataclass(frozen=True, eq=False)
class Information:
    """The information of rows about the parameters. It is additive over parts of the rows that share no errors."""

    plain: Array  # R factor of the plain residuals' derivatives J by all parameters, (d or less, d)
    weighed: Array  # the same of the residuals that were minimised, W^(1/2) J
    spread: Array  # JᵀWΣWJ, (d, d): covariance of the fit's gradient under the noise Σ
    reach: Array  # largest derivative by each parameter, (d,)

    @classmethod
    def of(cls, J: Array, noise: NoiseModel, *, weights: NoiseModel | None = None) -> "Information":
        """The information of some rows of the data.

        Args:
            J: Plain residuals by all parameters, (d, m, k).
            noise: Of the residuals.
            weights: The noise by which the minimised residuals were whitened; None for plain ones.
        """
        flat = J.reshape(len(J), -1)
        plain, reach = triangle(flat.T), np.abs(flat).max(axis=1, initial=0.0)
        if weights is None:
            return cls(plain, plain, noise.seen_through(flat.T), reach)
        white = weights.whiten(J)
        return cls(plain, triangle(white.T), noise.seen_through(weights.weigh(white).T), reach)

    @classmethod
    def of_known_distances(cls, model: Model, x: Array, number_scale: float = 1.0) -> "Information":
        """The information at x (d,) of the rows that state distances between points; zero where there are none.

        Their errors are independent, with a variance σ² each. The fit minimises s² δ²/σ² of a residual δ, so the row's
        weight is s²/σ²; s is `Problem.number_scale`.
        """
        known = model.known_distances
        if known is None:
            none = np.empty((0, len(x)))
            return cls(none, none, np.zeros((len(x), len(x))), np.zeros(len(x)))
        slopes = known.jacobian(model.parameters.values(x[None]), model.parameters.names)[0]
        weighed = number_scale / known.sigma_m * slopes
        return cls(slopes, weighed, number_scale**2 * weighed.T @ weighed, np.abs(slopes).max(axis=0))

    def __add__(self, other: "Information") -> "Information":
        return Information(
            triangle(self.plain, other.plain),
            triangle(self.weighed, other.weighed),
            self.spread + other.spread,
            np.maximum(self.reach, other.reach),
        )

    def without(self, gone: Bools) -> "Information":
        """As if the residuals did not depend on these parameters, (d,)."""
        plain, weighed, reach = (np.where(gone, 0.0, part) for part in (self.plain, self.weighed, self.reach))
        return Information(plain, weighed, np.where(gone | gone[:, None], 0.0, self.spread), reach)

    def covariance(self, free: Ints) -> Array:
        """Covariance of the parameters that were free, by their indices (f,), under the real noise, (f, f).

        Least squares with weights W gives (JᵀWJ)⁻¹ JᵀWΣWJ (JᵀWJ)⁻¹: with weights W = Σ⁻¹ that is (JᵀΣ⁻¹J)⁻¹.
        Inverses omit null directions, so parameters that take part in one seem exact here: see `standard_errors`.
        """
        inverse = self.inverse(free)
        return np.asarray(inverse @ self.spread[np.ix_(free, free)] @ inverse)

    def variances(self, free: Ints) -> Array:
        """Of the same parameters, (f,), where rounding makes none negative."""
        return np.maximum(np.diag(self.covariance(free)), 0.0)

    def inverse(self, free: Ints) -> Array:
        """(JᵀWJ)⁺ of the free parameters, (f, f)."""
        R = self.weighed[:, free]
        scale = lengths(R)
        _, s, Vt = np.linalg.svd(R / scale, full_matrices=False)
        seen = s > NULL * s.max(initial=0.0)
        return np.asarray((Vt[seen].T / s[seen] ** 2) @ Vt[seen] / scale / scale[:, None])


NULL = 1e-7
"""Singular values of the Jacobian, its columns of unit length, below this share of the largest are zero.

Its numerical derivatives are exact to about 1e-10; the weakest real direction seen on 25 points is at 1e-5.
"""


def lengths(J: Array) -> Array:
    """Length of each column, (k, d) -> (d,); 1 for a column of zeros."""
    norms: Array = np.linalg.norm(J, axis=0)
    return np.where(norms > 0.0, norms, 1.0)


def information(problem: Problem, x: Array, sigmas: Mapping[str, float], shots: Ints | None = None) -> Information:
    """The information of all rows at the optimum, known distances included.

    Args:
        problem: What was minimised.
        x: The optimum, (d,).
        sigmas: Standard deviation of each source of noise.
        shots: Over how many each row was averaged, (m,); 1 when absent.
    """
    distances = Information.of_known_distances(problem.model, x, problem.number_scale)
    shared = shared_by_rows(problem.model)
    batches = (
        _of_batch(batch, x, sigmas, None if shots is None else shots[rows], shared=shared)
        for rows, batch in problem.batches
    )
    known = reduce(add, batches, distances)
    return known.without(known.reach * problem.parameters.width <= UNMOVED)


def _of_batch(
    batch: Problem, x: Array, sigmas: Mapping[str, float], shots: Ints | None, *, shared: bool
) -> Information:
    # sizes are judged by averaged rows: where each pose then has one, they know no errors that its shots would share
    sources = tuple(source for source in error_sources(batch.model, x, shots, shared=shared) if source.name in sigmas)
    noise = NoiseModel(sources, sigmas)
    return Information.of(jacobian(batch.model, x[None])[0], noise, weights=batch.noise)
