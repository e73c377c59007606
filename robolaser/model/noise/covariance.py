"""Measurement errors in residuals: their sources and sizes, and residuals whitened by them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.model.error_source import ErrorSource
from robolaser.model.grouped_rows import GroupedRows, group_sums
from robolaser.model.noise.whitening import GroupStage, Whitener

FLOOR = 1e-6
"""Standard deviation of every number of a row in its own unit, added to all: no covariance becomes singular."""
REGULAR = 1e-13
"""Least share of a row's variances in each of its numbers: rows with errors of metres keep a Cholesky factor."""

Origin = Literal["stated", "repeats", "estimated"]


@final
@dataclass(frozen=True)
class NoiseModel:
    """The errors of a data set's rows: independent between poses, correlated within."""

    sources: tuple[ErrorSource, ...]  # of the rows' errors, see `robolaser.model.noise.sources`
    sigmas: Mapping[str, float]  # standard deviation of each source, by name, in its unit
    # where each size comes from: "stated", "repeats", or "estimated" from the residuals
    origin: Mapping[str, Origin] = field(default_factory=dict)
    relative: bool = False  # whether whitened rows are of unit variance only up to a common factor

    @property
    def estimated(self) -> tuple[str, ...]:
        """Sources with sizes from residuals or repeats, not from the data set."""
        return tuple(name for name, origin in self.origin.items() if origin != "stated")

    def at(self, sigmas: Mapping[str, float]) -> "NoiseModel":
        """The same sources with other sizes; those not named keep theirs."""
        return replace(self, sigmas={**self.sigmas, **sigmas})

    def for_weights(self) -> "NoiseModel":
        """The noise for weights: all but estimated errors of whole poses.

        Those contain unmodelled effects. Weights with them would trust the model within each pose, where it fails. The
        rest gives the relative errors of rows, no longer their size.
        """
        gone = [source.name for source in self.sources if source.level == "pose" and source.name in self.estimated]
        return replace(self.at(dict.fromkeys(gone, 0.0)), relative=self.relative or bool(gone))

    def of_rows(self, rows: Ints) -> "NoiseModel":
        """The noise of some rows, whole poses of them."""
        sources = (
            replace(source, effect=source.effect[rows], group=np.unique(source.group[rows], return_inverse=True)[1])
            for source in self.sources
        )
        return replace(self, sources=tuple(sources))

    @cached_property
    def _whitener(self) -> Whitener:
        own = self._floor()
        levels: list[tuple[Array, Ints]] = []
        of_poses: list[tuple[Array, Ints]] = []
        shaking = (source for source in self.sources if self.sigmas[source.name] > 0.0)
        for source in sorted(shaking, key=lambda source: len(np.unique(source.group)), reverse=True):
            effect = self.sigmas[source.name] * source.effect
            into = of_poses if source.level == "pose" else levels
            if source.level != "pose" and len(np.unique(source.group)) == self._rows:
                own += effect @ np.swapaxes(effect, -1, -2)
            elif into and np.array_equal(into[-1][1], source.group):
                into[-1] = (np.concatenate([into[-1][0], effect], axis=-1), source.group)
            else:
                into.append((effect, source.group))
        least = REGULAR * np.einsum("mii->m", own) - FLOOR**2
        own += np.maximum(least, 0.0)[:, None, None] * np.eye(self.numbers)
        return Whitener.of(own, [*levels, *of_poses])

    @cached_property
    def _of_poses(self) -> GroupStage | None:
        """The stage that whitens errors of whole poses, always the last one; None where there are none."""
        shaking = any(source.level == "pose" and self.sigmas[source.name] > 0.0 for source in self.sources)
        return self._whitener.stages[-1] if shaking else None

    @property
    def scatter(self) -> Array:
        """Variance that errors of whole poses add to each direction in which they move a pose, (n q,).

        In units of the variance without them; empty where there are none.
        """
        return np.zeros(0) if self._of_poses is None else self._of_poses.spectrum[0].reshape(-1)

    def scatter_squares(self, white: Array) -> Array:
        """Squares of whitened residuals (m k,) along the same directions, (n q,)."""
        rows = white.reshape(self._rows, self.numbers)
        return np.zeros(0) if self._of_poses is None else self._of_poses.squares(rows).reshape(-1)

    def with_scatter_times(self, factor: float) -> "NoiseModel":
        """The same with larger or smaller errors of whole poses."""
        return self.at({source.name: factor * self.sigmas[source.name] for source in self.sources_of_poses})

    @property
    def sources_of_poses(self) -> tuple[ErrorSource, ...]:
        """The sources of errors of whole poses."""
        return tuple(source for source in self.sources if source.level == "pose")

    @property
    def _rows(self) -> int:
        return len(self.sources[0].group)

    @property
    def numbers(self) -> int:
        """Numbers of a row, k."""
        return int(self.sources[0].effect.shape[1])

    def _floor(self) -> Array:
        k = self.numbers
        return np.broadcast_to(FLOOR**2 * np.eye(k), (self._rows, k, k)).copy()

    def whiten(self, residuals: Array) -> Array:
        """Make residuals independent and of unit variance, (c, m, k) or (c, m k) [row's unit] -> (c, m k)."""
        return self._whitener(residuals)

    def weigh(self, white: Array) -> Array:
        """Σ⁻¹ times residuals that are white already, (c, m k) -> (c, m k) [1/row's unit]."""
        return self._whitener.back(white)

    def precision(self, moves: Array) -> tuple[Array, list[tuple[Array, GroupedRows]]]:
        """Σ⁻¹ of numbers that move each row along (m, k) [row's unit], see `Whitener.precision`."""
        return self._whitener.precision(moves)

    def correlate(self, white: Array) -> Array:
        """The inverse of `whiten`, (c, m k) -> (c, m k) [row's unit]."""
        weighed = self.weigh(white)
        rows = weighed.reshape(len(white), self._rows, self.numbers).transpose(1, 2, 0)
        total: Array = FLOOR**2 * rows
        for source in self.sources:
            moved = rows if source.isotropic else np.swapaxes(source.effect, -1, -2) @ rows
            shared = self.sigmas[source.name] ** 2 * group_sums(moved, source.group)[source.group]
            total = total + (shared if source.isotropic else source.effect @ shared)
        return total.transpose(2, 0, 1).reshape(white.shape)

    def seen_through(self, J: Array) -> Array:
        """JᵀΣJ for a Jacobian (m k, d), -> (d, d)."""
        d = J.shape[1]
        rows = J.reshape(self._rows, self.numbers, d)
        total: Array = FLOOR**2 * (J.T @ J)
        for source in self.sources:
            moved = rows if source.isotropic else np.swapaxes(source.effect, -1, -2) @ rows
            shared = self.sigmas[source.name] * group_sums(moved, source.group).reshape(-1, d)
            total = total + shared.T @ shared
        return total

    @cached_property
    def covariances(self) -> Array:
        """Covariance of each row by itself, all sources together, (m, k, k) [row's unit²]."""
        total = self._floor()
        for source in self.sources:
            effect = self.sigmas[source.name] * source.effect
            total += effect @ np.swapaxes(effect, -1, -2)
        return total

    def size_m(self, in_metres: Callable[[Array], Array]) -> float:
        """Root-mean-square 3-D error of a row by this noise alone [m]; `in_metres` is of errors (m, k)."""
        roots = np.asarray(np.linalg.cholesky(self.covariances), dtype=np.float64)
        squares = [np.square(in_metres(roots[:, :, i])).sum(axis=-1) for i in range(roots.shape[2])]
        return float(np.sqrt(np.sum(squares, axis=0).mean()))
