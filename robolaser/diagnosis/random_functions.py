"""Random functions at sites beside a fitted model: their normal equations, from sums over poses.

A function of a pose coordinate moves all rows of a pose by the same amount. So the products of its basis functions
follow from sums over each pose's rows, which all functions of the same moved quantity share.
"""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.candidate_sites import Site
from robolaser.diagnosis.fit import Fit
from robolaser.model.grouped_rows import GroupedRows


@final
class RandomFunctions:
    """Functions at sites, without the part that fitted parameters imitate, beside functions that count as noise.

    Whitening for an accepted function B of size t multiplies residuals and all other columns by 1 - U D Uᵀ, where
    t B = U s Vᵀ and D = 1 - 1/√(1 + s²).
    """

    def __init__(self, fit: Fit) -> None:
        self._rows, self._Q, self._residuals = len(fit.at.white), fit.at.Q, fit.at.r
        self._accepted: list[tuple[Array, Array]] = []
        self._imitated, self._along = self._Q, self._back(self._residuals)[:, None]
        # the arrays whose identities are keys are kept with the values: no other array can take their place
        self._sums: dict[tuple[int, int, str], tuple[Array, Array]] = {}
        self._grouped: dict[int, GroupedRows] = {}

    def normal_equations(self, site: Site) -> Array:
        """Products of a function's columns with each other, (q p, q p)."""
        own = self._summed(site, "own", site.moves)
        q, p = site.moves.shape[1], site.basis.shape[1]
        if site.basis.size == 1:
            return np.asarray(own[0] * site.basis**2 - self.newly_imitated(site))
        G = np.empty((q, p, q, p))
        for i in range(q):
            for j in range(i + 1):
                G[i, :, j] = (site.basis * own[:, i, [j]]).T @ site.basis
                G[j, :, i] = G[i, :, j].T
        return np.asarray(G.reshape(q * p, q * p) - self.newly_imitated(site))

    def largest_square(self, site: Site) -> float:
        """Squared length of the longest of a function's columns, including the part that the parameters imitate."""
        squares = np.diagonal(self._summed(site, "own", site.moves), axis1=1, axis2=2)
        return float(((site.basis**2).T @ squares).max(initial=0.0))

    def newly_imitated(self, site: Site) -> Array:
        """Part of these products that the parameters, or else the last accepted function, imitate, (q p, q p)."""
        along = _over(site, self._summed(site, "imitated", self._imitated))
        return np.asarray(along @ along.T)

    def gradient(self, site: Site) -> Array:
        """Products of a function's columns with the residuals, (q p,)."""
        return _over(site, self._summed(site, "gradient", self._along))[:, 0]

    def believe(self, site: Site, size: float) -> None:
        """Accept a function of a size: count it as noise."""
        columns = np.zeros((len(self._Q), site.moves.shape[1] * site.basis.shape[1]))
        columns[: self._rows] = site.columns
        columns -= self._Q @ (self._Q.T @ columns)
        for one in self._accepted:
            columns = _whitened(columns, *one)
        U, s, _ = np.linalg.svd(size * columns, full_matrices=False)
        self._imitated = self._back(U * (s / np.sqrt(1.0 + s**2)))
        self._accepted.append((U, 1.0 - 1.0 / np.sqrt(1.0 + s**2)))
        self._residuals = _whitened(self._residuals, *self._accepted[-1])
        self._along = self._back(self._residuals)[:, None]
        self._sums = {key: sums for key, sums in self._sums.items() if key[2] == "own"}

    def _back(self, columns: Array) -> Array:
        """Apply the transpose of the whitening and projection of a function's columns to columns (K + e, ...)."""
        for one in reversed(self._accepted):
            columns = _whitened(columns, *one)
        return np.asarray(columns - self._Q @ (self._Q.T @ columns))

    def _summed(self, site: Site, what: str, by: Array) -> Array:
        """Products of a site's moves (K, q) with columns (K, d), summed over each pose or row, (n, q, d)."""
        key = id(site.moves), len(site.basis), what
        if key not in self._sums:
            rows = self._grouped.setdefault(len(site.basis), GroupedRows(site.of_number))
            own = np.swapaxes(rows.apart(site.moves), 1, 2) @ rows.apart(by[: self._rows])
            sums = np.zeros((len(site.basis), *own.shape[1:]))
            sums[: len(own)] = own
            self._sums[key] = site.moves, sums
        return self._sums[key][1]


def _whitened(columns: Array, U: Array, less: Array) -> Array:
    return np.asarray(columns - (U * less) @ (U.T @ columns))


def _over(site: Site, sums: Array) -> Array:
    """Products of the basis functions with sums over each pose or row (n, q, d): (q p, d)."""
    products = site.basis.T @ sums.swapaxes(0, 1)
    return np.asarray(products.reshape(len(products) * products.shape[1], sums.shape[2]))  # no columns: all are fixed
