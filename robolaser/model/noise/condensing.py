"""Fewer numbers that say as much about how large errors are.

Errors of whole poses move all rows of a pose together, in a few directions. In all others there are nothing but errors
of each row's own, as those of pixels are, alike and independent: these directions may be turned among each other, over
all poses, until only as many as there are fitted numbers hold anything. The rest is zero, and is counted.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools

UNMOVED = 1e-12  # variance by a source, over the largest, up to which it does not move a number
FEW = 0.5  # share of a pose's numbers up to which it is worthwhile to part the directions that its errors move


@final
@dataclass(frozen=True, eq=False)
class PoseErrors:
    """What a fit left over at each pose, and what may have caused it."""

    unit: Mapping[str, Array]  # covariance that a unit of each source causes, (n, s, s) by name
    floor: Array  # covariance that is there without any, regular, (n, s, s)
    e: Array  # residuals, (n, s)
    Q: Array  # a basis of what the fitted numbers can do to them, (n, s, d)
    times: Array  # how often each pose is there, (n,)


def condensed(errors: PoseErrors, is_row: Bools) -> PoseErrors:
    """The same likelihood, up to a constant, of fewer numbers; all of them where there is little to part.

    Args:
        errors: Of poses, each there once.
        is_row: Whether a pose has this number, (n, s). Others have no residual, and a floor of one.
    """
    n, s = is_row.shape
    own = {name: size for name, C in errors.unit.items() if (size := _alike(C, is_row)) is not None}
    moved = sum((C / C.max() for name, C in errors.unit.items() if name not in own and C.any()), np.zeros((n, s, s)))
    shaken, U = np.linalg.eigh(moved - np.eye(s) * ~is_row[:, None])  # ascending: numbers that no pose has come first
    q = int((shaken > UNMOVED * shaken.max()).sum(axis=1).max())
    if not 0 < q <= FEW * s:
        return errors
    apart, alike = U[..., s - q :], U[..., : s - q]
    rows = np.concatenate([errors.Q, errors.e[..., None]], axis=2)
    _, R = np.linalg.qr((np.swapaxes(alike, 1, 2) @ rows).reshape(n * (s - q), -1))
    few = np.concatenate([R, np.zeros((-len(R) % q + q, R.shape[1]))]).reshape(-1, q, R.shape[1])
    others = (is_row.sum() - np.minimum(is_row.sum(axis=1), q).sum()) / q  # poses of q numbers
    if others < len(few):
        return errors
    rows = np.concatenate([np.swapaxes(apart, 1, 2) @ rows, few])

    def turned(C: Array, of_own: float) -> Array:
        rest = np.broadcast_to(of_own * np.eye(q), (len(few), q, q))
        return np.concatenate([np.swapaxes(apart, 1, 2) @ C @ apart, rest])

    times = np.ones(len(rows))
    times[-1] = 1.0 + others - len(few)
    unit = {name: turned(C, own.get(name, 0.0)) for name, C in errors.unit.items()}
    floor = turned(errors.floor, errors.floor[_diagonal(is_row)].min())
    return PoseErrors(unit, floor, rows[..., -1], rows[..., :-1], times)


def _diagonal(is_row: Bools) -> Bools:
    return is_row[:, :, None] & np.eye(is_row.shape[1], dtype=bool)


def _alike(C: Array, is_row: Bools) -> float | None:
    """Variance by a source that moves each number by itself, and all alike; None for any other source."""
    size = float(C.max())
    return size if np.allclose(C, size * _diagonal(is_row), rtol=0.0, atol=UNMOVED * size) else None
