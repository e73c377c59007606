"""Three angles of a turn and how it changes with them, in compiled loops."""

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.decorators import compiled
from robolaser.geometry.frame_loops import turned_xyz, turned_zyz

TAU = 2 * np.pi


@compiled
def turn(angles: Array, zyz: bool, R: Array, axes: Array) -> None:
    """As `elimination.turns.turn` for one candidate, into R (3, 3) and axes (3, 3)."""
    c, s = np.cos(angles[0]), np.sin(angles[0])
    axes[:] = 0.0
    if zyz:
        T = turned_zyz(angles[0], angles[1], angles[2])
        axes[0, 2], axes[1, 0], axes[1, 1] = 1.0, -s, c
    else:
        T = turned_xyz(angles[0], angles[1], angles[2])
        axes[0, 0], axes[1, 1], axes[1, 2] = 1.0, c, s
    R[0, 0], R[0, 1], R[0, 2] = T[0], T[1], T[2]
    R[1, 0], R[1, 1], R[1, 2] = T[4], T[5], T[6]
    R[2, 0], R[2, 1], R[2, 2] = T[8], T[9], T[10]
    for i in range(3):
        axes[2, i] = R[i, 2]


@compiled
def along(axes: Array, G: Array, R: Array, first: Array, second: Array) -> None:
    """As `elimination.turns.along` for one candidate, of <R, G>, into first (3,) and second (3, 3)."""
    n_00, n_01, n_02 = _row(G, R, 0)
    n_10, n_11, n_12 = _row(G, R, 1)
    n_20, n_21, n_22 = _row(G, R, 2)
    trace = n_00 + n_11 + n_22
    for k in range(3):
        a_0, a_1, a_2 = axes[k, 0], axes[k, 1], axes[k, 2]
        first[k] = a_0 * (n_21 - n_12) + a_1 * (n_02 - n_20) + a_2 * (n_10 - n_01)
        m_0 = n_00 * a_0 + n_01 * a_1 + n_02 * a_2
        m_1 = n_10 * a_0 + n_11 * a_1 + n_12 * a_2
        m_2 = n_20 * a_0 + n_21 * a_1 + n_22 * a_2
        for j in range(k, 3):
            b_0, b_1, b_2 = axes[j, 0], axes[j, 1], axes[j, 2]
            value = b_0 * m_0 + b_1 * m_1 + b_2 * m_2 - trace * (a_0 * b_0 + a_1 * b_1 + a_2 * b_2)
            second[k, j], second[j, k] = value, value


@compiled
def _row(G, R, i):  # type: ignore[no-untyped-def]
    """A row of G Rᵀ."""
    return (
        G[i, 0] * R[0, 0] + G[i, 1] * R[0, 1] + G[i, 2] * R[0, 2],
        G[i, 0] * R[1, 0] + G[i, 1] * R[1, 1] + G[i, 2] * R[1, 2],
        G[i, 0] * R[2, 0] + G[i, 1] * R[2, 1] + G[i, 2] * R[2, 2],
    )


@compiled
def angles_within(R: Array, zyz: bool, lower: Array, upper: Array, angles: Array) -> None:
    """As `elimination.turns.angles_within` for one candidate, into angles (3,)."""
    if zyz:
        phi = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
        w = np.arctan2(R[1, 2], R[0, 2]) if R[0, 2] != 0.0 or R[1, 2] != 0.0 else 0.0
        c, s = np.cos(w), np.sin(w)
        psi = np.arctan2(c * R[1, 0] - s * R[0, 0], c * R[1, 1] - s * R[0, 1])
        other = -phi
    else:
        cos = np.hypot(R[0, 0], R[0, 1])
        phi = np.arctan2(R[0, 2], cos)
        w = np.arctan2(-R[1, 2], R[2, 2]) if cos > 0.0 else 0.0
        c, s = np.cos(w), np.sin(w)
        psi = np.arctan2(c * R[1, 0] + s * R[2, 0], c * R[1, 1] + s * R[2, 1])
        other = np.pi - phi
    first = _wrapped(w, lower[0], upper[0]), _wrapped(phi, lower[1], upper[1]), _wrapped(psi, lower[2], upper[2])
    second = (
        _wrapped(w + np.pi, lower[0], upper[0]),
        _wrapped(other, lower[1], upper[1]),
        _wrapped(psi + np.pi, lower[2], upper[2]),
    )
    out_first = out_second = 0.0
    for i, (one, two) in enumerate(zip(first, second)):  # noqa: B905 - numba has no strict
        out_first += abs(one - min(max(one, lower[i]), upper[i]))
        out_second += abs(two - min(max(two, lower[i]), upper[i]))
    nearer = first if out_first <= out_second else second
    angles[0], angles[1], angles[2] = nearer


@compiled
def _wrapped(angle, lower, upper):  # type: ignore[no-untyped-def]
    return angle - TAU * np.round((angle - (lower + upper) / 2) / TAU)
