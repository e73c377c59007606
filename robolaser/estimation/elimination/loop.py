"""The sum of squares of loops through arm, sensor and target, as a quadratic form in what closes them."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints


@final
@dataclass(frozen=True)
class Loops:
    """Σ |V χ - (R U φ + t)|² over all rows, R and t being the flange's, as zᵀ M z with z = (V, U, 1), rows first.

    V (3, g) holds what is fixed in the base frame, U (3, f) what is fixed in the flange frame.

    Attributes:
        form: M, (c, N, N), N = 3 g + 3 f + 1.
        g: Columns of V.
        f: Columns of U.
    """

    form: Array
    g: int
    f: int

    @classmethod
    def of(cls, chi: Array, phi: Array, R: Array, t: Array) -> "Loops":
        """Sum over the rows.

        Args:
            chi: χ, (c or 1, m, g).
            phi: φ, (c or 1, m, f).
            R: Of the flange at each row, (c or 1, m, 3, 3).
            t: Of the flange at each row, (c or 1, m, 3) [m].
        """
        c, m = max(len(chi), len(phi), len(R)), chi.shape[1]
        g, f = chi.shape[2], phi.shape[2]
        v, u = 3 * g, 3 * f
        M = np.zeros((c, v + u + 1, v + u + 1))
        pairs = (chi[..., :, None] * phi[..., None, :]).reshape(-1, m, g * f)
        met = np.swapaxes(pairs, 1, 2) @ R.reshape(-1, m, 9)
        back = np.einsum("cmji,cmj->cmi", R, t)
        chi2, phi2 = np.swapaxes(chi, 1, 2) @ chi, np.swapaxes(phi, 1, 2) @ phi
        for a in range(3):
            M[:, a * g : (a + 1) * g, a * g : (a + 1) * g] = chi2
            M[:, v + a * f : v + (a + 1) * f, v + a * f : v + (a + 1) * f] = phi2
        across = -met.reshape(-1, g, f, 3, 3).transpose(0, 3, 1, 4, 2).reshape(-1, v, u)
        M[:, :v, v:-1] = across
        M[:, :v, -1] = -(np.swapaxes(t, 1, 2) @ chi).reshape(-1, v)
        M[:, v:-1, -1] = (np.swapaxes(back, 1, 2) @ phi).reshape(-1, u)
        M[:, -1, -1] = (t**2).sum(axis=(1, 2))
        M[:, v:-1, :v] = np.swapaxes(M[:, :v, v:-1], 1, 2)
        M[:, -1, :-1] = M[:, :-1, -1]
        return cls(M, g, f)

    def without(self, columns: Ints) -> tuple[Array, Array]:
        """Put the best values of some entries of z in place of them.

        Args:
            columns: Where they stand in z, (k,).

        Returns:
            The form in the entries that remain, (c, N - k, N - k), and what gives the others from them,
            (c, k, N - k).
        """
        rest = np.setdiff1d(np.arange(self.form.shape[1]), columns)
        inner = self.form[:, columns[:, None], columns]
        between = self.form[:, columns[:, None], rest]
        gives = -np.linalg.pinv(inner, rcond=1e-12, hermitian=True) @ between
        return self.form[:, rest[:, None], rest] + np.swapaxes(between, 1, 2) @ gives, gives
