"""Scanner and target both unplaced: the hand-eye, the scale and the target's pose that close the loops best."""

from dataclasses import dataclass
from functools import partial
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled import available, share_out
from robolaser.estimation.elimination.loop import Loops
from robolaser.estimation.elimination.newton import minimise
from robolaser.estimation.elimination.turns import along, angles_within, turn
from robolaser.geometry.rigid_motion import nearest_rotation

AT_ONCE = 10  # candidates that a thread takes at a time: half a millisecond
UNSEEN = 1e-7  # share of the largest eigenvalue below which flat points tell nothing of a direction
SHIFT, TURN = slice(4, 7), slice(10, 13)
COLUMNS = (3, 7, 11, 15, 19, 23)  # of the two shifts in z: V = (R_target, t_target), U = (λ B R, t)


@final
@dataclass(frozen=True)
class Room:
    """Bounds of what is found: the 12 numbers behind the scale λ, in the order of `place`'s result.

    Attributes:
        bracket: B, (3, 3).
        order: Of the angles of R.
        lower: (12,).
        upper: (12,).
        start: Where to start besides the linear relaxation, (12,); its target's pose is not looked at.
    """

    bracket: Array
    order: str
    lower: Array
    upper: Array
    start: Array


def place(loops: Loops, room: Room, scale: Array) -> Array:
    """What leaves the least of Σ |R_t P + t_t - T_flange (λ B R p + t)|² within bounds.

    Newton's method from the linear relaxation, for either sign of λ that the bounds allow, and from the nominal
    hand-eye; the target begins where the hand-eye puts it.

    Args:
        loops: With χ = (P, 1) and φ = (p, 1).
        room: The bounds.
        scale: Lower and upper bounds of λ, (c, 2).

    Returns:
        λ, angles of R (3) [rad], t (3) [m], t_t (3) [m], angles of R_t (3) [rad]: (c, 13).
    """
    c = len(scale)
    low = np.column_stack([scale[:, 0], np.broadcast_to(room.lower, (c, 12))])
    high = np.column_stack([scale[:, 1], np.broadcast_to(room.upper, (c, 12))])
    nominal = np.column_stack([np.clip(np.ones(c), *scale.T), np.broadcast_to(room.start, (c, 12))])
    starts = [nominal]
    for sign in (1.0, -1.0):
        if ((scale[:, 1] > 0) if sign > 0 else (scale[:, 0] < 0)).any():
            starts.append(_relaxed(loops, room, sign))
    found, least = np.zeros((c, 13)), np.full(c, np.inf)
    for start in starts:
        x, J = _downhill(loops, room, _with_target(loops, room, np.clip(start, low, high)), low, high)
        better = least > J
        found[better], least[better] = x[better], J[better]
    return found


def _downhill(loops: Loops, room: Room, start: Array, low: Array, high: Array) -> tuple[Array, Array]:
    size = np.abs(loops.form[:, -1, -1])
    if not available():
        return minimise(_Objective(loops, room), start, low, high, size)
    from robolaser.estimation.elimination.newton_loops import minimise as go_down  # noqa: PLC0415 - numba takes a third of a second to load

    c = len(start)
    B = np.broadcast_to(room.bracket.reshape(9), (c, 9))
    x, J = np.clip(start, low, high), np.empty(c)
    given = np.column_stack([np.broadcast_to(loops.form.reshape(-1, 625), (c, 625)), B]), room.order == "zyz"
    size = np.broadcast_to(size, c).copy()
    share_out(partial(go_down, i, min(i + AT_ONCE, c), *given, x, low, high, size, J) for i in range(0, c, AT_ONCE))
    return x, J


def _relaxed(loops: Loops, room: Room, sign: float) -> Array:
    """The best hand-eye if nothing held a rotation's nine numbers together, and the scaled rotation nearest to it."""
    Q, gives = loops.without(np.array(COLUMNS))
    inner = Q[:, :-1, :-1]
    loose = -np.linalg.pinv(inner, rcond=UNSEEN, hermitian=True) @ Q[:, :-1, -1:]
    W = room.bracket.T @ loose[:, 9:, 0].reshape(-1, 3, 3)
    R, s = nearest_rotation(sign * W)
    scale = sign * (s[:, 0] + s[:, 1]) / 2
    closed = np.concatenate([loose, np.ones((len(Q), 1, 1))], axis=1)
    closed[:, 9:18, 0] = (scale[:, None, None] * room.bracket @ R).reshape(-1, 9)
    x = np.zeros((len(Q), 13))
    x[:, 0], x[:, 1:4] = scale, angles_within(R, room.order, room.lower[:3], room.upper[:3])
    x[:, SHIFT] = (gives @ closed)[:, 3:, 0]
    return x


def _with_target(loops: Loops, room: Room, x: Array) -> Array:
    """The same with the target where the scanner's points lie, by a rigid fit (Umeyama 1991)."""
    R, _ = turn(x[:, 1:4], room.order)
    U = np.concatenate([x[:, :1, None] * (room.bracket @ R), x[:, SHIFT, None]], axis=2).reshape(-1, 12, 1)
    seen = -(loops.form[:, :12, 12:24] @ U + loops.form[:, :12, 24:]).reshape(-1, 3, 4)
    known = loops.form[:, :4, :4]
    count = known[:, 3:, 3:]
    cross = seen[:, :, :3] - seen[:, :, 3:] * known[:, 3:, :3] / count
    R_target, _ = nearest_rotation(cross)
    placed = x.copy()
    placed[:, 7:10] = ((seen[:, :, 3:] - R_target @ known[:, :3, 3:]) / count)[:, :, 0]
    placed[:, TURN] = angles_within(R_target, "xyz", room.lower[9:], room.upper[9:])
    return placed


class _Objective:
    """zᵀ M z of λ and the 12 numbers behind it, with its derivatives."""

    def __init__(self, loops: Loops, room: Room) -> None:
        self._form, self._room = loops.form, room

    def __call__(self, x: Array, which: Ints) -> tuple[Array, Array, Array]:
        B, M, k = self._room.bracket, self._form[which], len(which)
        scale = x[:, 0]
        R, axes = turn(x[:, 1:4], self._room.order)
        R_t, axes_t = turn(x[:, TURN], "xyz")
        z = np.ones((k, 25))
        V, U = z[:, :12].reshape(k, 3, 4), z[:, 12:24].reshape(k, 3, 4)
        V[:, :, :3], V[:, :, 3] = R_t, x[:, 7:10]
        BR = B @ R
        U[:, :, :3], U[:, :, 3] = scale[:, None, None] * BR, x[:, SHIFT]
        Z = np.zeros((k, 25, 13))
        dV, dU = Z[:, :12].reshape(k, 3, 4, 13), Z[:, 12:24].reshape(k, 3, 4, 13)
        dU[:, :, :3, 0] = BR
        for i in range(3):
            dU[:, :, :3, 1 + i] = scale[:, None, None] * (B @ np.cross(axes[:, i, :, None], R, axis=1))
            dV[:, :, :3, 10 + i] = np.cross(axes_t[:, i, :, None], R_t, axis=1)
            dU[:, i, 3, 4 + i] = 1.0
            dV[:, i, 3, 7 + i] = 1.0
        Mz = (M @ z[..., None])[..., 0]
        g = 2 * (np.swapaxes(Z, 1, 2) @ Mz[..., None])[..., 0]
        H = 2 * np.swapaxes(Z, 1, 2) @ (M @ Z)
        pull = B.T @ Mz[:, 12:24].reshape(k, 3, 4)[:, :, :3]
        first, second = along(axes, pull @ np.swapaxes(R, 1, 2))
        _, second_t = along(axes_t, Mz[:, :12].reshape(k, 3, 4)[:, :, :3] @ np.swapaxes(R_t, 1, 2))
        H[:, 0, 1:4] += 2 * first
        H[:, 1:4, 0] += 2 * first
        H[:, 1:4, 1:4] += 2 * scale[:, None, None] * second
        H[:, TURN, TURN] += 2 * second_t
        return np.einsum("ki,ki->k", z, Mz), g, H
