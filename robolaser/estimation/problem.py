"""The least-squares problem: whitened residuals of a model as a function of its parameters, within bounds."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.estimation.robust_loss import SQUARE, Loss
from robolaser.model.forward_model import Model, batches_of, jacobian
from robolaser.model.noise.covariance import NoiseModel
from robolaser.parameters import Parameters


@final
@dataclass(frozen=True, eq=False)
class Problem:
    """Minimise the cost of a model's rows, and of its parameters' distances from their nominal values.

    Residuals are flat, (c, K): the numbers of row 0, of row 1, and so on, however many numbers a row has.
    `calibrate` solves it without priors, `diagnose` with weak ones.
    """

    model: Model  # data and effects
    parameters: Parameters  # the model's; for some of the data, the whole model's, to keep its closed forms
    noise: NoiseModel | None = None  # whitens the rows; None leaves them in the sensor's unit
    loss: Loss = SQUARE  # what a whitened row costs
    prior: Array | None = None  # standard deviation about nominal values, (d,), infinite where free; None: everywhere
    # standard deviation of a row's numbers, where they are not whitened by all their noise: it weighs them against
    # known distances; None: as at the nominal values
    row_size: float | None = None
    shift: Array | None = None  # a constant that is added to the residuals, (K,)

    @classmethod
    def of(
        cls,
        model: Model,
        noise: NoiseModel | None = None,
        *,
        prior: Array | None = None,
        parameters: Parameters | None = None,
    ) -> "Problem":
        """The problem of a model; see the attributes."""
        return cls(model, parameters or model.parameters, noise, prior=prior)

    def with_noise(self, noise: NoiseModel | None) -> "Problem":
        """The same with other weights."""
        return replace(self, noise=noise, row_size=None)

    @cached_property
    def fixed(self) -> Bools:
        """Parameters that stay at their nominal values, by the sensor's gauge or by bounds without room, (d,)."""
        gauge = np.isin(self.parameters.names, self.model.blocks.held)
        return np.asarray(gauge | (self.parameters.upper <= self.parameters.lower))

    @cached_property
    def lower(self) -> Array:
        """Lower bounds, the nominal values of fixed parameters, (d,)."""
        return np.where(self.fixed, self.parameters.nominal, self.parameters.lower)

    @cached_property
    def upper(self) -> Array:
        """Upper bounds, likewise, (d,)."""
        return np.where(self.fixed, self.parameters.nominal, self.parameters.upper)

    @cached_property
    def scale(self) -> Array:
        """A usual change of each parameter, (d,): the distance of its bounds."""
        width = self.parameters.width
        return np.where(width > 0.0, width, 1.0)

    def on_bound(self, x: Array) -> Bools:
        """Free parameters on one of their bounds, (..., d)."""
        return np.asarray(~self.fixed & ((x <= self.lower) | (x >= self.upper)))

    @cached_property
    def rows(self) -> int:
        """How many rows the data have."""
        return len(self.model.dataset.points)

    @cached_property
    def numbers(self) -> int:
        """How many numbers the rows have: K, less those that are zero because a row has fewer than others."""
        return int(self.model.blocks.row_numbers.sum())

    @cached_property
    def starts(self) -> Ints:
        """Where the numbers of each row begin, (m,)."""
        return np.arange(self.rows, dtype=np.int64) * self.model.blocks.numbers

    @cached_property
    def row_of_number(self) -> Ints:
        """Row of each number, (K,)."""
        return np.repeat(np.arange(self.rows, dtype=np.int64), self.model.blocks.numbers)

    def plain(self, x: Array) -> Array:
        """Residuals as the sensor has them, (c, d) -> (c, m, k)."""
        return self.model.residuals(x)

    def residuals(self, x: Array) -> Array:
        """Whitened residuals, (c, d) -> (c, K)."""
        white = self.whitened(self.plain(x))
        return white if self.shift is None else white + self.shift

    def whitened(self, plain: Array) -> Array:
        """Plain residuals (c, m, k) as the problem weighs them, (c, K)."""
        return plain.reshape(len(plain), -1) if self.noise is None else self.noise.whiten(plain)

    def jacobian(self, x: Array) -> Array:
        """Derivatives of the whitened residuals by each parameter over its scale, (c, d) -> (c, d, K)."""
        J = jacobian(self.model, x)
        c, d = J.shape[:2]
        white = self.whitened(J.reshape(c * d, *J.shape[2:])).reshape(c, d, -1)
        white *= np.where(self.fixed, 0.0, self.scale)[:, None]
        return white

    @cached_property
    def _prior_slopes(self) -> Array:
        """Change of a parameter's distance from its nominal value, over its prior, by a step of one scale, (d,)."""
        if self.prior is None:
            return np.zeros(len(self.scale))
        return np.where(self.fixed, 0.0, self.scale / np.where(self.prior > 0.0, self.prior, np.inf))

    def with_rows_of_size(self, x: Array) -> "Problem":
        """The same with the standard deviation that a row's numbers have at x (d,)."""
        return replace(self, row_size=float(np.sqrt(np.square(self.residuals(x[None])).sum() / self.numbers)))

    @cached_property
    def number_scale(self) -> float:
        """Factor of known distances over their standard deviation, see `Model.extra_residuals`.

        One where rows are whitened by all their noise; else the standard deviation of their numbers.
        """
        whole = self.noise is not None and not self.noise.relative
        if whole or self.model.known_distances is None:
            return 1.0
        return self.row_size or self.with_rows_of_size(self.parameters.nominal).row_size or 1.0

    def extra_residuals(self, x: Array) -> Array:
        """Rows beyond those of the data, (c, d) -> (c, e): known distances, then the prior's, one a parameter.

        They count in every fit, whichever rows of the data are left out.
        """
        prior = self._prior_slopes * (x - self.parameters.nominal) / self.scale
        return np.concatenate([self.number_scale * self.model.extra_residuals(x), prior], axis=1)

    def extra_jacobian(self, x: Array) -> Array:
        """Derivatives of these by each parameter over its scale, (c, d) -> (c, d, e)."""
        prior = np.broadcast_to(np.diag(self._prior_slopes), (len(x), x.shape[1], x.shape[1]))
        known = self.model.known_distances
        if known is None:
            return prior
        slopes = known.jacobian(self.parameters.values(x), self.parameters.names) / known.sigma_m
        slopes = self.number_scale * np.swapaxes(slopes, 1, 2) * np.where(self.fixed, 0.0, self.scale)[:, None]
        return np.concatenate([slopes, prior], axis=2)

    def costs(self, x: Array) -> Array:
        """Cost of candidates, (c, d) -> (c,); infinite at the model's poles."""
        rows = sum(batch.loss.costs(batch.residuals(x), batch.starts) for _, batch in self.batches)
        return np.asarray(rows + np.square(self.extra_residuals(x)).sum(axis=1))

    @cached_property
    def batches(self) -> tuple[tuple[Ints, "Problem"], ...]:
        """The rows in batches of whole poses, as memory allows: row numbers (m,), and their problem.

        Extra rows belong to the whole alone; shifted rows are one batch.
        """
        parts = batches_of(self.model) if self.shift is None else ()
        if len(parts) <= 1:
            return ((np.arange(self.rows, dtype=np.int64), self),)
        return tuple(
            (rows, replace(self, model=part, noise=None if self.noise is None else self.noise.of_rows(rows)))
            for rows, part in parts
        )
