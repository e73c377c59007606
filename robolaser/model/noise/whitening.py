"""Making correlated rows independent and of unit variance, without ever forming their covariance.

A covariance that is block-diagonal in rows plus low rank in ever larger groups is whitened in stages: each row by
the inverse Cholesky factor of its own 3 × 3 block, then each level of groups by I − U K Uᵀ with
K = V diag(1 / (√(1+s²) (1+√(1+s²)))) Vᵀ, UᵀU = V diag(s²) Vᵀ, which is (I + U Uᵀ)^(-1/2).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled import available, share_out

AT_ONCE = 10_000
"""Candidates times rows that a thread whitens at a time."""


def group_sums(rows: Array, group: Ints) -> Array:
    """Sum rows (m, ...) that share a group's number (m,), -> (largest number + 1, ...)."""
    apart = np.diff(group)
    if (apart < 0).any():
        order = np.argsort(group, kind="stable")
        rows, group = rows[order], group[order]
    elif len(group) == group[-1] + 1 and (apart > 0).all():
        return rows
    numbers, starts = np.unique(group, return_index=True)
    sums = np.zeros((int(group[-1]) + 1, *rows.shape[1:]))
    sums[numbers] = np.add.reduceat(rows, starts, axis=0)
    return sums


@final
@dataclass(frozen=True)
class Stage:
    """(I + U Uᵀ)^(-1/2) for each group of rows.

    Attributes:
        shared: U, what the group's shared errors do to each row once all finer levels are white, (m, 3, q).
        group: (m,).
    """

    shared: Array
    group: Ints

    @cached_property
    def kernel(self) -> Array:
        """K of each group, (largest number + 1, q, q)."""
        gram = group_sums(np.swapaxes(self.shared, -1, -2) @ self.shared, self.group)
        s2, V = np.linalg.eigh(gram)
        root = np.sqrt(1.0 + np.maximum(s2, 0.0))
        kernel: Array = (V / (root * (1.0 + root))[:, None]) @ np.swapaxes(V, -1, -2)
        return kernel

    def __call__(self, rows: Array) -> Array:
        """Whiten (m, 3, c)."""
        common = group_sums(np.swapaxes(self.shared, -1, -2) @ rows, self.group)
        white: Array = rows - self.shared @ (self.kernel @ common)[self.group]
        return white


@final
@dataclass(frozen=True)
class Whitener:
    """W with W Σ Wᵀ = I.

    Attributes:
        root: Inverse Cholesky factor of each row's own covariance, (m, 3, 3) [1/m].
        stages: Finer groups first.
    """

    root: Array
    stages: tuple[Stage, ...]

    @classmethod
    def of(cls, own: Array, levels: Sequence[tuple[Array, Ints]]) -> "Whitener":
        """Prepare.

        Args:
            own: Covariance of each row by itself, (m, 3, 3) [m²].
            levels: Effects (m, 3, q) [m] of unit errors that groups (m,) of rows share; finer groups first, each
                group within one of the next level.
        """
        root = np.linalg.inv(np.linalg.cholesky(own))
        stages: tuple[Stage, ...] = ()
        for effect, group in levels:
            white = root @ effect
            for stage in stages:
                white = stage(white)
            stages = (*stages, Stage(white, group))
        return cls(root, stages)

    def __call__(self, residuals: Array) -> Array:
        """Whiten residuals, (c, m, 3) or (c, 3m) [m] -> (c, 3m)."""
        c = len(residuals)
        if available():
            return self._compiled(np.ascontiguousarray(residuals.reshape(c, -1, 3)))
        rows = self.root @ np.ascontiguousarray(residuals.reshape(c, -1).T).reshape(-1, 3, c)
        for stage in self.stages:
            rows = stage(rows)
        return rows.reshape(-1, c).T

    def _compiled(self, residuals: Array) -> Array:
        from robolaser.model.noise.whitening_loops import by_group, by_row  # noqa: PLC0415 - numba takes time to load

        white = np.empty_like(residuals)

        def part(first: int, last: int) -> None:
            by_row(first, last, self.root, residuals, white)
            for stage in self.stages:
                by_group(first, last, stage.shared, stage.group, stage.kernel, white)

        c, m = len(residuals), len(self.root)
        size = -(-AT_ONCE // m)
        share_out(partial(part, i, min(i + size, c)) for i in range(0, c, size))
        return white.reshape(c, -1)

    def back(self, white: Array) -> Array:
        """Wᵀ: after W it makes Σ⁻¹, (c, 3m) -> (c, 3m)."""
        c = len(white)
        rows = np.ascontiguousarray(white.T).reshape(-1, 3, c)
        for stage in reversed(self.stages):
            rows = stage(rows)
        return (np.swapaxes(self.root, -1, -2) @ rows).reshape(-1, c).T
