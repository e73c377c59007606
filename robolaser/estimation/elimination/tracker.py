"""A tracker's pose and the reflectors on the flange that its measured points ask for."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.estimation.elimination.loop import Loops
from robolaser.estimation.elimination.newton import minimise
from robolaser.estimation.elimination.turns import along, angles_within, turn
from robolaser.geometry.rigid_motion import exp_so3, nearest_rotation

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

    Given the rotation all else is linear: the rotation is followed downhill from the relaxation and from the best of
    many. Where what follows breaks a bound, all together goes on from there.

    Args:
        loops: With χ = (y, 1), and φ one for the row's tool and zero for all others.
        room: The bounds.

    Returns:
        Angles of R, s, tools: (c, 6 + 3 k).
    """
    c, k = len(loops.form), loops.f
    linear = np.concatenate([[3, 7, 11], np.arange(12, 12 + 3 * k)])
    Q, gives = loops.without(linear)
    size = np.abs(loops.form[:, -1, -1])
    angles, least = np.zeros((c, 3)), np.full(c, np.inf)
    anywhere = np.full((c, 3), np.inf)
    for R in np.moveaxis(_starts(Q), 1, 0):
        start = angles_within(R, "xyz", room.lower[:3], room.upper[:3])
        tried, J = minimise(_Turned(Q), start, -anywhere, anywhere, size)
        better = least > J
        angles[better], least[better] = tried[better], J[better]
    R, _ = turn(angles, "xyz")
    back = np.concatenate([np.swapaxes(R, 1, 2).reshape(c, 9, 1), np.ones((c, 1, 1))], axis=1)
    rest = (gives @ back)[:, :, 0]
    tools = np.swapaxes(rest[:, 3:].reshape(c, 3, k), 1, 2).reshape(c, 3 * k)
    turned = angles_within(R, "xyz", room.lower[:3], room.upper[:3])
    found = np.column_stack([turned, -(R @ rest[:, :3, None])[:, :, 0], tools])
    breaks = np.flatnonzero(((found < room.lower) | (found > room.upper)).any(axis=1))
    if len(breaks):
        low, high = (np.broadcast_to(bound, (len(breaks), 6 + 3 * k)) for bound in (room.lower, room.upper))
        objective = _Objective(loops.form[breaks], k)
        found[breaks], _ = minimise(objective, found[breaks], low, high, size[breaks])
    return found


def _starts(Q: Array) -> Array:
    """Rotations worth starting from, (c, TRIED + 1, 3, 3), of the form in the entries of Rᵀ and 1."""
    loose = -np.linalg.pinv(Q[:, :9, :9], rcond=1e-9, hermitian=True) @ Q[:, :9, 9:]
    relaxed, _ = nearest_rotation(np.swapaxes(loose.reshape(-1, 3, 3), 1, 2))
    seeds = exp_so3(np.random.default_rng(0).normal(size=(SEEDS, 3)) * 2.0)
    z = np.column_stack([np.swapaxes(seeds, 1, 2).reshape(-1, 9), np.ones(SEEDS)])
    left = np.einsum("sk,csk->cs", z, z @ Q)
    best = np.argsort(left, axis=1, kind="stable")[:, :TRIED]
    return np.concatenate([relaxed[:, None], seeds[best]], axis=1)


class _Turned:
    """zᵀ Q z of three angles, z = (Rᵀ, 1), with its derivatives."""

    def __init__(self, Q: Array) -> None:
        self._form = Q

    def __call__(self, x: Array, which: Ints) -> tuple[Array, Array, Array]:
        Q, c = self._form[which], len(which)
        R, axes = turn(x, "xyz")
        z = np.ones((c, 10))
        z[:, :9] = np.swapaxes(R, 1, 2).reshape(c, 9)
        turned = np.cross(axes[:, :, :, None], R[:, None], axis=2)
        Z = np.swapaxes(turned, 2, 3).reshape(c, 3, 9)
        Qz = (Q @ z[..., None])[..., 0]
        pull = np.swapaxes(Qz[:, :9].reshape(c, 3, 3), 1, 2)
        first, second = along(axes, pull @ np.swapaxes(R, 1, 2))
        H = 2 * (Z @ Q[:, :9, :9] @ np.swapaxes(Z, 1, 2) + second)
        return np.einsum("ki,ki->k", z, Qz), 2 * first, H


class _Objective:
    """zᵀ M z of angles, shift and tools, with its derivatives: V = (Rᵀ, -Rᵀ s), U the tools."""

    def __init__(self, form: Array, tools: int) -> None:
        self._form, self._tools = form, tools

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
