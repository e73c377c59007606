"""The R factor of a least-squares problem: all that its solution needs of the rows.

With A = Q R, |A p| = |R p| for every p: a million rows and the square R have the same minimum. Rows come in parts, each
put below the triangle of those before it (Golub 1965; Demmel, Grigori, Hoemmen, Langou 2012, TSQR).
"""

import numpy as np

from robolaser.arrays import Array

TALL = 2048  # rows taken in at a time, which the processor's cache holds,
TALLER = 4  # or so many times the width, so that work on the triangle itself stays small beside them


def triangle(rows: Array, above: Array | None = None) -> Array:
    """Put rows (k, w) below a triangle (w or less, w), or under nothing: R of them all, (w or less, w)."""
    height = max(TALL, TALLER * rows.shape[1])
    R = rows[:0] if above is None else above
    for start in range(0, len(rows), height):
        R = np.asarray(np.linalg.qr(np.concatenate([R, rows[start : start + height]]), mode="r"))
    return R
