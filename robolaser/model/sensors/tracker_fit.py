"""Placements of a tracker and of its reflectors on the flange, from measured points: start values for a fit."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.subsampling import rows_of_each
from robolaser.geometry.rigid_motion import exp_so3, nearest_rotation, skew

ENOUGH_ROWS = 3000  # rows for start values
SEEDS = 500  # rotations tried; no rotation is farther from the nearest of them than some 30°
TRIED = 3  # of them, those with the smallest residuals are refined, and the linear relaxation
STEPS = 50
RANK = 1e-9  # of the largest eigenvalue: directions below are not determined


def enough_of_each(number: Ints) -> Ints:
    """Rows (m,) for start values, as many of each reflector or body, by its number, (k,)."""
    few = len(number) <= ENOUGH_ROWS
    return np.arange(len(number)) if few else rows_of_each(number, ENOUGH_ROWS // (int(number.max()) + 1) + 1)


def base_and_tools(measured: Array, T_base_flange: Array, tool: Ints) -> tuple[Array, Array, Array]:
    """The minimizer of Σ |R (R_i tool + t_i) + s − y_i|², R refined from the best of many.

    With A = Rᵀ and c = Rᵀ s the error A y_i − c − R_i tool − t_i is linear in all unknowns: c and the tools are
    projected out (Golub, Pereyra 1973), which leaves a quadratic form in the nine entries of A.

    Args:
        measured: y in the tracker's frame, (c or 1, m, 3) [m].
        T_base_flange: Of each row, (c or 1, m, 4, 4).
        tool: Number of each row's reflector, (m,); each occurs.

    Returns:
        R_world_base (c, 3, 3), its shift s (c, 3) [m], the reflectors in the flange frame (c, t, 3) [m].
    """
    middle = measured.mean(axis=1, keepdims=True)
    design = _design(measured - middle, T_base_flange, tool)
    N = np.swapaxes(design, 1, 2) @ design
    linear, entries = np.r_[9 : N.shape[1] - 1], np.r_[:9, N.shape[1] - 1]
    mixed = N[:, linear[:, None], entries]
    gives = -np.linalg.pinv(N[:, linear[:, None], linear], rcond=RANK**2, hermitian=True) @ mixed
    Q = N[:, entries[:, None], entries] + np.swapaxes(mixed, 1, 2) @ gives
    refined, left = _refined(Q.repeat(1 + TRIED, axis=0), _starts(Q).reshape(-1, 3, 3))
    best = left.reshape(len(Q), -1).argmin(axis=1)
    A = refined.reshape(len(Q), -1, 3, 3)[np.arange(len(Q)), best]
    rest = (gives @ _entries(A)[..., None])[..., 0]
    R = np.swapaxes(A, 1, 2)
    shift = middle[:, 0] + (R @ rest[:, :3, None])[..., 0]
    return R, shift, rest[:, 3:].reshape(len(R), -1, 3)


def _design(y: Array, T: Array, tool: Ints) -> Array:
    """Columns of the linear error: entries of A row by row, c, the tools, and the constant, (c, 3m, 13 + 3t)."""
    c, m, tools = max(len(y), len(T)), len(tool), int(tool.max()) + 1
    design = np.zeros((c, m, 3, 13 + 3 * tools))
    for axis in range(3):
        design[:, :, axis, 3 * axis : 3 * axis + 3] = y
        design[:, :, axis, 9 + axis] = -1.0
    for number in range(tools):
        own = tool == number
        design[:, own, :, 12 + 3 * number : 15 + 3 * number] = -T[:, own, :3, :3]
    design[..., -1] = -T[..., :3, 3]
    return design.reshape(c, 3 * m, -1)


def _starts(Q: Array) -> Array:
    """Rotations worth refining, (c, 1 + TRIED, 3, 3): the linear relaxation, and the best of many."""
    loose = -np.linalg.pinv(Q[:, :9, :9], rcond=RANK, hermitian=True) @ Q[:, :9, 9:]
    relaxed, _ = nearest_rotation(loose.reshape(-1, 3, 3))
    seeds = exp_so3(np.random.default_rng(0).normal(size=(SEEDS, 3)) * 2.0)
    z = _entries(seeds)
    left = np.einsum("sk,csk->cs", z, z @ Q)
    best = np.argsort(left, axis=1, kind="stable")[:, :TRIED]
    return np.concatenate([relaxed[:, None], seeds[best]], axis=1)


def _refined(Q: Array, A: Array) -> tuple[Array, Array]:
    """Damped Gauss-Newton steps A ← exp(ω) A on zᵀ Q z, z = (A, 1); the rotations and their residuals, (c,)."""
    cost, damping = _form(Q, A), np.full(len(A), 1e-3)
    slopes, axes = np.zeros((len(A), 10, 3)), skew(np.eye(3))
    for _ in range(STEPS):
        slopes[:, :9] = (axes @ A[:, None]).reshape(-1, 3, 9).swapaxes(1, 2)
        Qz = (Q @ _entries(A)[..., None])[..., 0]
        H = np.swapaxes(slopes, 1, 2) @ Q @ slopes
        H = H + damping[:, None, None] * np.einsum("cii->c", H)[:, None, None] * np.eye(3)
        step = -(np.linalg.pinv(H, hermitian=True) @ (np.swapaxes(slopes, 1, 2) @ Qz[..., None]))[..., 0]
        moved = exp_so3(step) @ A
        cost_moved = _form(Q, moved)
        better = cost_moved < cost
        A = np.where(better[:, None, None], moved, A)
        cost = np.where(better, cost_moved, cost)
        damping = np.where(better, damping / 10.0, damping * 10.0)
        if (np.linalg.norm(step, axis=-1) < 1e-12).all():
            break
    return A, cost


def _form(Q: Array, A: Array) -> Array:
    z = _entries(A)
    return np.asarray(np.einsum("ci,cij,cj->c", z, Q, z))


def _entries(A: Array) -> Array:
    return np.concatenate([A.reshape(-1, 9), np.ones((len(A), 1))], axis=1)
