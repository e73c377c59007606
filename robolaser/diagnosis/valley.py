"""A linear model of residuals, taken apart once for steps of several dampings."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array

DAMPINGS = np.array([0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-2])
"""Levenberg's, relative to the square of the largest singular value: all are tried at once."""
EPS = 1e-12
"""Singular values below this share of the largest belong to parameters that are held."""


@final
@dataclass(frozen=True)
class Valley:
    """Singular vectors and values of a Jacobian, as far as it moves anything.

    Attributes:
        U: (k, n).
        s: (n,).
        Vt: (n, d).
    """

    U: Array
    s: Array
    Vt: Array

    @classmethod
    def of(cls, J: Array) -> "Valley":
        """Take a Jacobian (k, d) apart."""
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        seen = s > EPS * s[0]
        return cls(U[:, seen], s[seen], Vt[seen])

    def promise(self, r: Array) -> float:
        """By how much the best step would lower the square of residuals (k,)."""
        return float(((self.U.T @ r) ** 2).sum())

    def steps(self, r: Array) -> Array:
        """The best step against residuals (k,) for each damping, (len(DAMPINGS), d)."""
        filters = self.s / (self.s**2 + DAMPINGS[:, None] * self.s[0] ** 2)
        found: Array = -(filters * (self.U.T @ r)) @ self.Vt
        return found
