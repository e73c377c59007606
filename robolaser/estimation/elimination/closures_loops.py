"""What the steps towards a scanner's mounting go down: sums of squares with gradients and Hessians, compiled.

A problem is a row of numbers. With four unknowns it is a similarity fit whose shift is clipped: means of p and d,
Bᵀ Σ d pᵀ about them, Σ |p|², Σ |d|², the number of points, B, bounds of the shift. With thirteen it is a quadratic form
M (25, 25) in a target's pose, a scaled hand-eye and one, and B. See `elimination.similarity` and
`elimination.placement` for both in readable form.
"""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.decorators import compiled
from robolaser.estimation.elimination.turns_loops import along, turn

SIMILARITY, PLACEMENT = 33, 634
"""Length of a row."""


@compiled
def desk() -> Any:
    """Room to work in: R, its axes, the target's, theirs, derivatives, and what each objective keeps."""
    R, axes, G, second, R_t, axes_t = (
        np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    )  # fmt: skip
    return R, axes, G, second, np.empty(3), R_t, axes_t, np.empty(25), np.empty(25), np.empty((7, 9)), np.empty((7, 24))


@compiled
def objective(problem: Array, zyz: bool, x: Array, g: Array, H: Array, room: Any) -> Any:
    """Value at x; the gradient goes to g and the Hessian to H."""
    if len(x) == 4:
        return _similarity(problem, zyz, x, g, H, room)
    return _placement(problem, zyz, x, g, H, room)


@compiled
def _similarity(problem, zyz, x, g, H, room):  # type: ignore[no-untyped-def]
    R, axes, G, second, first = room[0], room[1], room[2], room[3], room[4]
    p_0, p_1, p_2 = problem[0], problem[1], problem[2]
    pp, dd, count, scale = problem[15], problem[16], problem[17], x[0]
    turn(x[1:], zyz, R, axes)
    q_0 = R[0, 0] * p_0 + R[0, 1] * p_1 + R[0, 2] * p_2
    q_1 = R[1, 0] * p_0 + R[1, 1] * p_1 + R[1, 2] * p_2
    q_2 = R[2, 0] * p_0 + R[2, 1] * p_1 + R[2, 2] * p_2
    e_0 = _beyond(problem, scale, q_0, q_1, q_2, 0)
    e_1 = _beyond(problem, scale, q_0, q_1, q_2, 1)
    e_2 = _beyond(problem, scale, q_0, q_1, q_2, 2)
    overlap = linear = 0.0
    for i in range(3):
        back = count * (problem[18 + i] * e_0 + problem[21 + i] * e_1 + problem[24 + i] * e_2)
        linear += back * (R[i, 0] * p_0 + R[i, 1] * p_1 + R[i, 2] * p_2)
        G[i, 0], G[i, 1], G[i, 2] = problem[6 + 3 * i], problem[7 + 3 * i], problem[8 + 3 * i]
        overlap += R[i, 0] * G[i, 0] + R[i, 1] * G[i, 1] + R[i, 2] * G[i, 2]
        G[i, 0] += back * p_0
        G[i, 1] += back * p_1
        G[i, 2] += back * p_2
    along(axes, G, R, first, second)
    g[0] = 2 * (scale * pp - linear - overlap)
    H[0, 0] = 2 * pp
    for k in range(3):
        g[1 + k] = -2 * scale * first[k]
        H[0, 1 + k] = H[1 + k, 0] = -2 * first[k]
        for j in range(3):
            H[1 + k, 1 + j] = -2 * scale * second[k, j]
    for i in range(3):
        if (e_0, e_1, e_2)[i] != 0.0:
            b_0, b_1, b_2 = problem[18 + 3 * i], problem[19 + 3 * i], problem[20 + 3 * i]
            by_scale = b_0 * q_0 + b_1 * q_1 + b_2 * q_2
            H[0, 0] += 2 * count * by_scale * by_scale
            for k in range(3):
                first[k] = scale * (
                    b_0 * (axes[k, 1] * q_2 - axes[k, 2] * q_1)
                    + b_1 * (axes[k, 2] * q_0 - axes[k, 0] * q_2)
                    + b_2 * (axes[k, 0] * q_1 - axes[k, 1] * q_0)
                )
                H[0, 1 + k] += 2 * count * by_scale * first[k]
                H[1 + k, 0] = H[0, 1 + k]
                for j in range(k + 1):
                    H[1 + k, 1 + j] += 2 * count * first[k] * first[j]
                    H[1 + j, 1 + k] = H[1 + k, 1 + j]
    return dd - 2 * scale * overlap + scale * scale * pp + count * (e_0 * e_0 + e_1 * e_1 + e_2 * e_2)


@compiled
def _beyond(problem, scale, q_0, q_1, q_2, i):  # type: ignore[no-untyped-def]
    """How far the shift would have to go beyond its bounds along an axis."""
    wanted = problem[3 + i] - scale * (
        problem[18 + 3 * i] * q_0 + problem[19 + 3 * i] * q_1 + problem[20 + 3 * i] * q_2
    )
    return wanted - min(max(wanted, problem[27 + i]), problem[30 + i])


@compiled
def _placement(problem, zyz, x, g, H, room):  # type: ignore[no-untyped-def]  # noqa: PLR0912 - spelled out for the compiler
    R, axes, G, second, first, R_t, axes_t, z, Mz, D, MD = room
    M, B, scale = problem[:625].reshape(25, 25), problem[625:], x[0]
    turn(x[1:4], zyz, R, axes)
    turn(x[10:13], False, R_t, axes_t)  # noqa: FBT003
    for i in range(3):
        for j in range(3):
            D[0, 3 * i + j] = B[3 * i] * R[0, j] + B[3 * i + 1] * R[1, j] + B[3 * i + 2] * R[2, j]
            z[4 * i + j], z[12 + 4 * i + j] = R_t[i, j], scale * D[0, 3 * i + j]
        z[4 * i + 3], z[12 + 4 * i + 3] = x[7 + i], x[4 + i]
    z[24] = 1.0
    for k in range(3):
        a_0, a_1, a_2 = axes[k, 0], axes[k, 1], axes[k, 2]
        c_0, c_1, c_2 = axes_t[k, 0], axes_t[k, 1], axes_t[k, 2]
        for j in range(3):
            v_0, v_1, v_2 = a_1 * R[2, j] - a_2 * R[1, j], a_2 * R[0, j] - a_0 * R[2, j], a_0 * R[1, j] - a_1 * R[0, j]
            for i in range(3):
                D[1 + k, 3 * i + j] = scale * (B[3 * i] * v_0 + B[3 * i + 1] * v_1 + B[3 * i + 2] * v_2)
            D[4 + k, j] = c_1 * R_t[2, j] - c_2 * R_t[1, j]
            D[4 + k, 3 + j] = c_2 * R_t[0, j] - c_0 * R_t[2, j]
            D[4 + k, 6 + j] = c_0 * R_t[1, j] - c_1 * R_t[0, j]
    J = 0.0
    for i in range(25):
        total = 0.0
        for j in range(25):
            total += M[i, j] * z[j]
        Mz[i] = total
        J += total * z[i]
    for k in range(7):
        base = 12 if k < 4 else 0
        for i in range(24):
            total = 0.0
            for a in range(3):
                for j in range(3):
                    total += M[i, base + 4 * a + j] * D[k, 3 * a + j]
            MD[k, i] = total
    for k in range(7):
        at, base = (k, 12) if k < 4 else (k + 6, 0)
        total = 0.0
        for a in range(3):
            for j in range(3):
                total += Mz[base + 4 * a + j] * D[k, 3 * a + j]
        g[at] = 2 * total
        for n in range(k, 7):
            to = n if n < 4 else n + 6
            total = 0.0
            for a in range(3):
                for j in range(3):
                    total += MD[n, base + 4 * a + j] * D[k, 3 * a + j]
            H[at, to] = H[to, at] = 2 * total
        for a in range(3):
            H[at, 4 + a] = H[4 + a, at] = 2 * MD[k, 12 + 4 * a + 3]
            H[at, 7 + a] = H[7 + a, at] = 2 * MD[k, 4 * a + 3]
    for a in range(3):
        g[4 + a], g[7 + a] = 2 * Mz[12 + 4 * a + 3], 2 * Mz[4 * a + 3]
        for c in range(3):
            H[4 + a, 4 + c] = 2 * M[12 + 4 * a + 3, 12 + 4 * c + 3]
            H[7 + a, 7 + c] = 2 * M[4 * a + 3, 4 * c + 3]
            H[4 + a, 7 + c] = H[7 + c, 4 + a] = 2 * M[12 + 4 * a + 3, 4 * c + 3]
    for i in range(3):
        for j in range(3):
            G[i, j] = 0.0
            for a in range(3):
                G[i, j] += B[3 * a + i] * Mz[12 + 4 * a + j]
    along(axes, G, R, first, second)
    for k in range(3):
        H[0, 1 + k] += 2 * first[k]
        H[1 + k, 0] = H[0, 1 + k]
        for j in range(3):
            H[1 + k, 1 + j] += 2 * scale * second[k, j]
    for i in range(3):
        for j in range(3):
            G[i, j] = Mz[4 * i + j]
    along(axes_t, G, R_t, first, second)
    for k in range(3):
        for j in range(3):
            H[10 + k, 10 + j] += 2 * second[k, j]
    return J
