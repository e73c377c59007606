"""A tracker's pose and the reflectors on the flange that its measured points ask for."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.elimination.loop import Loops
from robolaser.elimination.newton import minimise
from robolaser.elimination.turns import along, angles_within, turn
from robolaser.se3 import exp_so3

SEEDS = 500  # rotations looked at; no turn is farther from the nearest of them than some 30°
TRIED = 3  # of them, those that leave least are followed downhill, and the linear relaxation


@final
@dataclass(frozen=True)
class Room:
    """Bounds of three angles [rad], three numbers of the shift and three of each tool [m], (6 + 3 k,) each."""

    lower: Array
    upper: Array


def follow(loops: Loops, room: Room) -> Array:
    """What leaves the least of Σ |R (R_flange tool + t_flange) + s - y|² within bounds.

    Given the rotation all else is linear. From the relaxation, and from the best of many rotations, by Newton's method.

    Args:
        loops: With χ = (y, 1), and φ one for the row's tool and zero for all others.
        room: The bounds.

    Returns:
        Angles of R, s, tools: (c, 6 + 3 k).
    """
    c, k = len(loops.form), loops.f
    linear = np.concatenate([[3, 7, 11], np.arange(12, 12 + 3 * k)])
    Q, gives = loops.without(linear)
    turns = _starts(Q)
    low, high = (np.broadcast_to(bound, (c, 6 + 3 * k)) for bound in (room.lower, room.upper))
    objective, size = _Objective(loops), np.abs(loops.form[:, -1, -1])
    found, least = np.zeros((c, 6 + 3 * k)), np.full(c, np.inf)
    for R in np.moveaxis(turns, 1, 0):
        back = np.swapaxes(R, 1, 2).reshape(c, 9, 1)
        rest = (gives @ np.concatenate([back, np.ones((c, 1, 1))], axis=1))[:, :, 0]
        x = np.zeros((c, 6 + 3 * k))
        x[:, :3] = angles_within(R, "xyz", room.lower[:3], room.upper[:3])
        x[:, 3:6] = -(R @ rest[:, :3, None])[:, :, 0]
        x[:, 6:] = np.swapaxes(rest[:, 3:].reshape(c, 3, k), 1, 2).reshape(c, 3 * k)
        x, J = minimise(objective, x, low, high, size)
        better = least > J
        found[better], least[better] = x[better], J[better]
    return found


def _starts(Q: Array) -> Array:
    """Rotations worth starting from, (c, TRIED + 1, 3, 3), of the form in the entries of Rᵀ and 1."""
    loose = -np.linalg.pinv(Q[:, :9, :9], rcond=1e-9, hermitian=True) @ Q[:, :9, 9:]
    U, _, Vt = np.linalg.svd(np.swapaxes(loose.reshape(-1, 3, 3), 1, 2))
    U[:, :, 2] *= np.where(np.linalg.det(U) * np.linalg.det(Vt) < 0, -1.0, 1.0)[:, None]
    seeds = exp_so3(np.random.default_rng(0).normal(size=(SEEDS, 3)) * 2.0)
    z = np.column_stack([np.swapaxes(seeds, 1, 2).reshape(-1, 9), np.ones(SEEDS)])
    left = np.einsum("sk,csk->cs", z, z @ Q)
    best = np.argsort(left, axis=1, kind="stable")[:, :TRIED]
    return np.concatenate([(U @ Vt)[:, None], seeds[best]], axis=1)


class _Objective:
    """zᵀ M z of angles, shift and tools, with its derivatives: V = (Rᵀ, -Rᵀ s), U the tools."""

    def __init__(self, loops: Loops) -> None:
        self._form, self._tools = loops.form, loops.f

    def __call__(self, x: Array, which: Ints) -> tuple[Array, Array, Array]:
        M, c, k = self._form[which], len(which), self._tools
        n = 6 + 3 * k
        R, axes = turn(x[:, :3], "xyz")
        s = x[:, 3:6]
        z = np.ones((c, 13 + 3 * k))
        V = z[:, :12].reshape(c, 3, 4)
        V[:, :, :3] = np.swapaxes(R, 1, 2)
        V[:, :, 3] = -np.einsum("cba,cb->ca", R, s)
        z[:, 12:-1] = np.swapaxes(x[:, 6:].reshape(c, k, 3), 1, 2).reshape(c, 3 * k)
        Z = np.zeros((c, 13 + 3 * k, n))
        dV = Z[:, :12].reshape(c, 3, 4, n)
        turned = [np.swapaxes(np.cross(axes[:, i, :, None], R, axis=1), 1, 2) for i in range(3)]
        for i in range(3):
            dV[:, :, :3, i] = turned[i]
            dV[:, :, 3, i] = -(turned[i] @ s[..., None])[..., 0]
            dV[:, :, 3, 3 + i] = -R[:, i]
            for tool in range(k):
                Z[:, 12 + i * k + tool, 6 + 3 * tool + i] = 1.0
        Mz = (M @ z[..., None])[..., 0]
        g = 2 * (np.swapaxes(Z, 1, 2) @ Mz[..., None])[..., 0]
        H = 2 * np.swapaxes(Z, 1, 2) @ (M @ Z)
        pull = Mz[:, :12].reshape(c, 3, 4)
        G = np.swapaxes(pull[:, :, :3], 1, 2) - s[:, :, None] * pull[:, None, :, 3]
        _, second = along(axes, G @ np.swapaxes(R, 1, 2))
        H[:, :3, :3] += 2 * second
        for i in range(3):
            mixed = -2 * np.einsum("cab,ca->cb", turned[i], pull[:, :, 3])
            H[:, i, 3:6] += mixed
            H[:, 3:6, i] += mixed
        return np.einsum("ki,ki->k", z, Mz), g, H
