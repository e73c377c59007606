"""Residuals made independent, candidate by candidate: each row by itself, then ever larger groups of rows."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled.decorators import compiled


@compiled
def by_row(first: int, last: int, root: Array, residuals: Array, white: Array) -> None:
    """Each row by the inverse Cholesky factor of its own covariance.

    Args:
        first: First candidate.
        last: The one after the last.
        root: Lower triangles, (m, 3, 3) [1/m].
        residuals: (c, m, 3) [m].
        white: Takes what comes out, (c, m, 3).
    """
    for i in range(first, last):
        for r in range(len(root)):
            x, y, z = residuals[i, r, 0], residuals[i, r, 1], residuals[i, r, 2]
            white[i, r, 0] = root[r, 0, 0] * x
            white[i, r, 1] = root[r, 1, 0] * x + root[r, 1, 1] * y
            white[i, r, 2] = root[r, 2, 0] * x + root[r, 2, 1] * y + root[r, 2, 2] * z


@compiled
def by_group(first: int, last: int, shared: Array, group: Ints, kernel: Array, white: Array) -> None:
    """Rows of a group less what their shared errors explain, in place.

    Args:
        first: First candidate.
        last: The one after the last.
        shared: U, (m, 3, q).
        group: Of each row, (m,).
        kernel: K of each group, (g, q, q).
        white: (c, m, 3).
    """
    g, q = kernel.shape[0], kernel.shape[1]
    common, known = np.empty((g, q)), np.empty((g, q))
    for i in range(first, last):
        common[:] = 0.0
        for r in range(len(group)):
            x, y, z = white[i, r, 0], white[i, r, 1], white[i, r, 2]
            for j in range(q):
                common[group[r], j] += shared[r, 0, j] * x + shared[r, 1, j] * y + shared[r, 2, j] * z
        for n in range(g):
            for j in range(q):
                total = 0.0
                for k in range(q):
                    total += kernel[n, j, k] * common[n, k]
                known[n, j] = total
        for r in range(len(group)):
            for axis in range(3):
                total = 0.0
                for j in range(q):
                    total += shared[r, axis, j] * known[group[r], j]
                white[i, r, axis] -= total
