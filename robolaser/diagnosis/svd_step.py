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
    """Singular values and vectors of a Jacobian, as far as it moves anything.

    Attributes:
        J: (k, d).
        s: (n,).
        Vt: (n, d).
    """

    J: Array
    s: Array
    Vt: Array

    @classmethod
    def of(cls, J: Array) -> "Valley":
        """Take a Jacobian (k, d) apart; what is tall costs less as a triangle."""
        _, s, Vt = np.linalg.svd(np.linalg.qr(J, mode="r"), full_matrices=False)
        seen = s > EPS * s[0]
        return cls(J, s[seen], Vt[seen])

    def _along(self, r: Array) -> Array:
        """Uᵀ r, (n,)."""
        along: Array = (self.Vt @ (self.J.T @ r)) / self.s
        return along

    def promise(self, r: Array) -> float:
        """By how much the best step would lower the square of residuals (k,)."""
        return float((self._along(r) ** 2).sum())

    def steps(self, r: Array) -> Array:
        """The best step against residuals (k,) for each damping, (len(DAMPINGS), d)."""
        filters = self.s / (self.s**2 + DAMPINGS[:, None] * self.s[0] ** 2)
        found: Array = -(filters * self._along(r)) @ self.Vt
        return found
