"""Making correlated rows independent and of unit variance, without ever forming their covariance.

A covariance that is block-diagonal in rows plus low rank in ever larger groups is whitened in stages: each row by
the inverse Cholesky factor of its own k × k block, then each level of groups by I − U K Uᵀ with
K = V diag(1 / (√(1+s²) (1+√(1+s²)))) Vᵀ, UᵀU = V diag(s²) Vᵀ, which is (I + U Uᵀ)^(-1/2).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.model.grouped_rows import GroupedRows, group_sums

MOTIONLESS = 1e-12  # variance over that of a white row, up to which a group's shared errors do not move a direction


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
