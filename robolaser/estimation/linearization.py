"""A problem near a point: residuals, their derivatives there, and quantities that follow from these alone."""

from dataclasses import dataclass
from functools import cached_property
from typing import cast, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.duals import Dual, slopes_of
from robolaser.estimation.problem import Problem
from robolaser.model.effects.effect import CandidateEffect
from robolaser.parameters import Values

TOUCH = 1e-6  # distance from a bound, as a share of the range, up to which a parameter is on it
RANK = 1e-12  # singular values below this share of the largest belong to directions that move no row
TALL = 2048  # rows taken in at a time, which the processor's cache holds,
TALLER = 4  # or so many times the width, so that work on the triangle itself stays small beside them


@final
@dataclass(frozen=True, eq=False)
class Linearization:
    """Rows are the K whitened numbers of the data and beneath them e extra ones: known distances, then the prior's."""

    problem: Problem  # of which
    x: Array  # where, (d,)
    known: Array | None = None  # derivatives of `white` there by each parameter over its scale, (K, d), if known

    @cached_property
    def plain(self) -> Array:
        """Residuals as the sensor has them, (m, k)."""
        return np.asarray(self.problem.plain(self.x[None])[0])

    @cached_property
    def white(self) -> Array:
        """Whitened residuals without the extra rows, (K,)."""
        return np.asarray(self.problem.whitened(self.plain[None])[0])

    @cached_property
    def r(self) -> Array:
        """Whitened residuals, the extra rows beneath, (K + e,)."""
        return np.concatenate([self.white, self.problem.extra_residuals(self.x[None])[0]])

    @cached_property
    def cost(self) -> float:
        """The minimised cost; with squares the squared length of `r`, infinite at the model's poles."""
        if not self.problem.loss.is_square:
            return float(self.problem.costs(self.x[None])[0])
        squares = float(self.r @ self.r)
        return squares if np.isfinite(squares) else np.inf

    @cached_property
    def slopes(self) -> Array:
        """Derivatives of `white` by every parameter over its scale, those on a bound too, (K, d)."""
        return np.asarray(self.problem.jacobian(self.x[None])[0].T) if self.known is None else self.known

    @cached_property
    def _every(self) -> Array:
        """Derivatives of `r` by every parameter over its scale, (K + e, d)."""
        return np.concatenate([self.slopes, self.problem.extra_jacobian(self.x[None])[0].T])

    @cached_property
    def touching(self) -> tuple[Bools, Bools]:
        """Parameters on their lower bound, and on their upper one, (d,) each."""
        near = TOUCH * self.problem.scale
        return self.x <= self.problem.lower + near, self.x >= self.problem.upper - near

    @cached_property
    def pushed(self) -> Bools:
        """Parameters on a bound that the cost would push beyond it, (d,)."""
        (low, high), gradient = self.touching, self._every.T @ self.r
        return np.asarray(~self.problem.fixed & ((low & (gradient > 0.0)) | (high & (gradient < 0.0))))

    @cached_property
    def free(self) -> Bools:
        """Parameters that can move, (d,)."""
        return np.asarray(~self.problem.fixed & ~self.pushed)

    @cached_property
    def J(self) -> Array:  # noqa: N802 - the letter that the field knows it by
        """Derivatives of `r` by each parameter over its scale, zero for those that cannot move, (K + e, d)."""
        return np.asarray(self._every * self.free)

    @cached_property
    def release(self) -> Array:
        """Derivatives of `r` by parameters pushed against a bound, away from it, (K + e, q)."""
        middle = (self.problem.lower + self.problem.upper) / 2.0
        ways = np.where(self.x < middle, 1.0, -1.0)[self.pushed]
        return np.asarray(self._every[:, self.pushed] * ways)

    @cached_property
    def _svd(self) -> tuple[Array, Array]:
        """Singular values (n,) and right vectors (n, d) of J, as far as it moves anything."""
        _, s, Vt = np.linalg.svd(triangle(self.J), full_matrices=False)
        seen = s > RANK * s.max(initial=0.0)
        return s[seen], Vt[seen]

    @cached_property
    def Q(self) -> Array:  # noqa: N802 - likewise
        """Orthonormal basis of the changes of `r` by the parameters, (K + e, n)."""
        s, Vt = self._svd
        return np.linalg.qr(self.J @ (Vt.T / s))[0]

    def step(self, r: Array) -> Array:
        """The undamped step against residuals (K + e,), as changes of the parameters, (d,)."""
        s, Vt = self._svd
        moved: Array = -Vt.T @ ((Vt @ (self.J.T @ r)) / s**2)
        return moved * self.problem.scale

    def project(self, columns: Array) -> Array:
        """The part of columns (K, q) or (K + e, q) that no parameter can imitate, (K + e, q)."""
        left: Array = self.Q @ -(self.Q[: len(columns)].T @ columns)
        left[: len(columns)] += columns
        return left

    def columns(self, effect: CandidateEffect, shapes: Array | None = None) -> Array:
        """Derivatives of `white` by the amplitudes of an effect that the model lacks, (g, K, q) per SI unit.

        At several values of its nonlinear parameters (g, s); at the nominal ones when absent.
        """
        problem = self.problem
        if shapes is None:
            shapes = np.array([[one.nominal for one in effect.effect.nonlinear_parameters()]])
        model = problem.model.with_effects((*problem.model.effects, effect))
        names, q = effect.parameters.names, len(effect.effect.amplitudes())
        values = problem.parameters.values(np.tile(self.x, (len(shapes), 1)))
        amplitudes = {name: Dual.parameter(np.zeros(len(shapes)), i) for i, name in enumerate(names[:q])}
        inner = dict(zip(names[q:], shapes.T, strict=True))
        J = slopes_of(model.residuals_at({**values, **cast("Values", amplitudes), **inner}), q)
        white = problem.whitened(J.reshape(-1, *self.plain.shape))
        return np.moveaxis(white.reshape(q, len(shapes), -1), 0, 2)

    @cached_property
    def covariance(self) -> Array:
        """Of the parameters where whitened rows have unit variance, (d, d) in their units.

        Zero for those that cannot move, and along directions that move no row.
        """
        s, Vt = self._svd
        inverse = Vt.T / s
        return self.problem.scale[:, None] * (inverse @ inverse.T) * self.problem.scale


def triangle(rows: Array, above: Array | None = None) -> Array:
    """The R factor of rows (k, w) below a triangle (w or less, w), or under nothing: (w or less, w).

    It is all that a least-squares solution needs of a million rows: with A = Q R, |A p| = |R p| for every p. Rows come
    in parts, each put below the triangle of those before it (Demmel, Grigori, Hoemmen, Langou 2012, TSQR).
    """
    height = max(TALL, TALLER * rows.shape[1])
    R = rows[:0] if above is None else above
    for start in range(0, len(rows), height):
        R = np.asarray(np.linalg.qr(np.concatenate([R, rows[start : start + height]]), mode="r"))
    return R
