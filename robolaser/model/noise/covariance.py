"""Measurement errors in residuals: their sources and sizes, and residuals whitened by them.

Their covariance, block-diagonal in rows plus low rank in ever larger groups, is never formed. It is whitened in stages:
each row by the inverse Cholesky factor of its own k × k block, then each level of groups by I − U K Uᵀ with
K = V diag(1 / (√(1+s²) (1+√(1+s²)))) Vᵀ, UᵀU = V diag(s²) Vᵀ, which is (I + U Uᵀ)^(-1/2).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.model.error_source import ErrorSource
from robolaser.model.grouped_rows import GroupedRows, group_sums

FLOOR = 1e-6
"""Standard deviation of every number of a row in its own unit, added to all: no covariance becomes singular."""
REGULAR = 1e-13
"""Least share of a row's variances in each of its numbers: rows with errors of metres keep a Cholesky factor."""
MOTIONLESS = 1e-12  # variance over that of a white row, up to which a group's shared errors do not move a direction

Origin = Literal["stated", "repeats", "estimated"]


@final
@dataclass(frozen=True)
class GroupStage:
    """(I + U Uᵀ)^(-1/2) for each group of rows."""

    shared: Array  # U, effect of the group's shared errors on each row after all finer levels are white, (m, k, q)
    group: Ints  # (m,)

    @cached_property
    def spectrum(self) -> tuple[Array, Array]:
        """Variances s² (g, q) that the shared errors add along orthogonal directions, and V (g, q, q)."""
        s2, V = np.linalg.eigh(group_sums(np.swapaxes(self.shared, -1, -2) @ self.shared, self.group))
        return np.maximum(s2, 0.0), V

    def squares(self, white: Array) -> Array:
        """Squares of white rows (m, k) along those directions, (g, q); zero along directions that do not move."""
        s2, V = self.spectrum
        common = group_sums((np.swapaxes(self.shared, -1, -2) @ white[..., None])[..., 0], self.group)
        along = (np.swapaxes(V, -1, -2) @ common[..., None])[..., 0]
        return np.divide(along**2, s2, out=np.zeros_like(s2), where=s2 > MOTIONLESS)

    @cached_property
    def groups(self) -> GroupedRows:
        """The rows by group."""
        return GroupedRows(np.unique(self.group, return_inverse=True)[1])

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        """U of each group with rows (g, r k, q) and K Uᵀ (g, q, r k), zero for missing rows."""
        shared = self.groups.apart(self.shared)
        shared = shared.reshape(len(shared), -1, shared.shape[-1])
        s2, V = (part[np.unique(self.group)] for part in self.spectrum)
        root = np.sqrt(1.0 + s2)
        K = (V / (root * (1.0 + root))[:, None]) @ np.swapaxes(V, -1, -2)
        return shared, K @ np.swapaxes(shared, 1, 2)

    def __call__(self, rows: Array) -> Array:
        """Whiten (m, k, c)."""
        grouped = self.groups.apart(rows)
        flat = grouped.reshape(len(grouped), grouped.shape[1] * grouped.shape[2], rows.shape[-1])
        U, KUt = self._factors
        return self.groups.together((flat - U @ (KUt @ flat)).reshape(grouped.shape))


@final
@dataclass(frozen=True)
class Whitener:
    """W with W Σ Wᵀ = I."""

    root: Array  # inverse Cholesky factor of each row's own covariance, (m, k, k) [1/row's unit]
    stages: tuple[GroupStage, ...]  # finer groups first

    @classmethod
    def of(cls, own: Array, levels: Sequence[tuple[Array, Ints]]) -> "Whitener":
        """Prepare the whitening of rows with given errors.

        Args:
            own: Covariance of each row by itself, (m, k, k) [row's unit²].
            levels: Effects (m, k, q) [row's unit] of unit errors that groups (m,) of rows share; finer groups first,
                each group within one of the next level.
        """
        root = np.linalg.inv(np.linalg.cholesky(own))
        stages: tuple[GroupStage, ...] = ()
        for effect, group in levels:
            white = root @ effect
            for stage in stages:
                white = stage(white)
            stages = (*stages, GroupStage(white, group))
        return cls(root, stages)

    def __call__(self, residuals: Array) -> Array:
        """Whiten residuals, (c, m, k) or (c, m k) [row's unit] -> (c, m k)."""
        return self._flat(self._staged(self.root @ self._rows(residuals), self.stages))

    def back(self, white: Array) -> Array:
        """Wᵀ: after W it makes Σ⁻¹, (c, m k) -> (c, m k)."""
        return self._flat(np.swapaxes(self.root, -1, -2) @ self._staged(self._rows(white), self.stages[::-1]))

    def precision(self, moves: Array) -> tuple[Array, list[tuple[Array, GroupedRows]]]:
        """Σ⁻¹ of numbers that move each row along (m, k): diag(own) - Σ C Cᵀ, C zero between groups.

        Returns:
            own (m,), and C (m, q) and the groups of the rows, for each level.
        """
        white = (self.root @ moves[..., None])[..., 0]
        levels = []
        for i, stage in enumerate(self.stages):
            s2, V = stage.spectrum
            along = stage.shared @ (V / np.sqrt(1.0 + s2)[:, None])[stage.group]
            levels.append(((white[..., None] * self._staged(along, self.stages[:i][::-1])).sum(axis=1), stage.groups))
        return np.square(white).sum(axis=1), levels

    def _rows(self, batch: Array) -> Array:
        """(c, m k) -> (m, k, c)."""
        m, k = self.root.shape[:2]
        return np.ascontiguousarray(batch.reshape(len(batch), m * k).T).reshape(m, k, len(batch))

    @staticmethod
    def _staged(rows: Array, stages: Sequence[GroupStage]) -> Array:
        for stage in stages:
            rows = stage(rows)
        return rows

    @staticmethod
    def _flat(rows: Array) -> Array:
        return rows.reshape(len(rows) * rows.shape[1], rows.shape[-1]).T


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

    def of_sources(self, sources: tuple[ErrorSource, ...]) -> "NoiseModel":
        """The same sizes for the sources of other rows; zero for those not known here."""
        return replace(self, sources=sources, sigmas={one.name: self.sigmas.get(one.name, 0.0) for one in sources})

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
        rows = self.weigh(white).reshape(len(white), self._rows, self.numbers).transpose(1, 2, 0)
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
