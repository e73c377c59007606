"""Where a scanner sits on the flange and how large it sees, once its points and the target's are known there."""

from dataclasses import dataclass
from functools import partial
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled import available, share_out
from robolaser.estimation.elimination.newton import minimise
from robolaser.estimation.elimination.patience import WIDE
from robolaser.estimation.elimination.turns import along, angles_within, turn
from robolaser.geometry.rigid_motion import nearest_rotation

AT_ONCE = 100  # candidates that a thread takes at a time: half a millisecond


@final
@dataclass(frozen=True)
class Moments:
    """What the sum of squares |d - (λ B R p + t)|² needs to know of points p and d, for each candidate.

    Attributes:
        count: Points.
        p: Mean of p, (c, 3) [m].
        d: Mean of d, (c, 3) [m].
        cross: Σ d pᵀ about the means, (c, 3, 3) [m²].
        pp: Σ |p|² about the mean, (c,) [m²].
        dd: Σ |d|² about the mean, (c,) [m²].
    """

    count: int
    p: Array
    d: Array
    cross: Array
    pp: Array
    dd: Array

    @classmethod
    def of(cls, p: Array, d: Array) -> "Moments":
        """Of points in the camera frame (c, m, 3) and in the flange frame (c or 1, m, 3), [m] both."""
        p_mean, d_mean = p.mean(axis=1), d.mean(axis=1)
        p_out, d_out = p - p_mean[:, None], d - d_mean[:, None]
        c = len(p)
        return cls(
            count=p.shape[1],
            p=p_mean,
            d=np.broadcast_to(d_mean, (c, 3)),
            cross=np.swapaxes(d_out, 1, 2) @ p_out,
            pp=_squares(p_out),
            dd=np.broadcast_to(_squares(d_out), c),
        )

    def take(self, which: Ints | Bools) -> "Moments":
        """Those of some candidates."""
        parts = (self.p, self.d, self.cross, self.pp, self.dd)
        return Moments(self.count, *(part[which] for part in parts))


@final
@dataclass(frozen=True)
class Room:
    """Bounds of what a similarity fit finds.

    Attributes:
        bracket: B, (3, 3).
        order: Of the angles.
        angles: Lower and upper bounds of the three angles of R, (2, 3) [rad].
        shift: Of t, (2, 3) [m].
    """

    bracket: Array
    order: str
    angles: Array
    shift: Array


def fit(p: Array, d: Array, room: Room, scale: Array) -> Array:
    """The scale λ, the angles of R and the shift t within bounds that leave the least of Σ |d - (λ B R p + t)|².

    The shift is a clip; where the best of all fits (Umeyama 1991) breaks a bound, scale and angles follow by Newton's
    method from there or, should an angle be out of bounds, from the middle of them: from both where they are wide, or
    where "zyz" has two ways to much the same turn. A scale may have either sign: a scanner whose laser is on the other
    side.

    Args:
        p: Points in the camera frame, (c, m, 3) [m].
        d: The same in the flange frame, (c or 1, m, 3) [m].
        room: The bounds.
        scale: Lower and upper bounds of λ, (c, 2).

    Returns:
        λ, angles [rad] and t [m], (c, 7); not a number where a point is not finite.
    """
    if available():
        return _compiled(p, d, room, scale)
    good = np.isfinite(p).all(axis=(1, 2)) & np.isfinite(d).all(axis=(1, 2))
    found = np.full((len(p), 7), np.nan)
    if np.any(good):
        found[good] = within(Moments.of(p[good], d if len(d) == 1 else d[good]), room, scale[good])
    return found


def _compiled(p: Array, d: Array, room: Room, scale: Array) -> Array:
    from robolaser.estimation.elimination.similarity_loops import fit as fitted  # noqa: PLC0415 - numba takes a third of a second to load

    found = np.empty((len(p), 7))
    (low, high), (least, most) = room.angles, room.shift
    p, d, bracket = (np.ascontiguousarray(array) for array in (p, d, room.bracket))
    given = p, d, bracket, room.order == "zyz", np.append(low, least), np.append(high, most), scale, found
    share_out(partial(fitted, i, min(i + AT_ONCE, len(p)), *given) for i in range(0, len(p), AT_ONCE))
    return found


def within(moments: Moments, room: Room, scale: Array) -> Array:
    """The same from moments, in NumPy."""
    c = len(moments.pp)
    least = np.full(c, np.inf)
    found = np.zeros((c, 4))
    for sign in (1.0, -1.0):
        able = (scale[:, 1] > 0) if sign > 0 else (scale[:, 0] < 0)
        if not able.any():
            continue
        ends, cost = _one_sign(moments.take(able), room, scale[able], sign)
        better = np.full(c, fill_value=False)
        better[able] = cost < least[able]
        found[better], least[better] = ends[better[able]], cost[better[able]]
    R, _ = turn(found[:, 1:], room.order)
    return np.column_stack([found, _shift(moments, room, found[:, 0], R)[0]])


def _one_sign(moments: Moments, room: Room, scale: Array, sign: float) -> tuple[Array, Array]:
    low = np.column_stack([np.maximum(scale[:, 0], 0.0) if sign > 0 else scale[:, 0], _rows(room.angles[0], scale)])
    high = np.column_stack([scale[:, 1] if sign > 0 else np.minimum(scale[:, 1], 0.0), _rows(room.angles[1], scale)])
    start = _umeyama(moments, room, sign)
    size = moments.dd + start[:, 0] ** 2 * moments.pp
    R, _ = turn(start[:, 1:], room.order)
    free, left = _shift(moments, room, start[:, 0], R)
    kept = ((start >= low) & (start <= high)).all(axis=1) & (left == 0).all(axis=1)
    ends = start.copy()
    cost = np.maximum(moments.dd - start[:, 0] ** 2 * moments.pp, 0.0)
    breaks = np.flatnonzero(~kept)
    if len(breaks):
        size = size[breaks] + moments.count * (free[breaks] ** 2 + left[breaks] ** 2).sum(axis=1)
        cost[breaks] = np.inf
        near = ((start >= low) & (start <= high))[breaks, 1:].all(axis=1)
        wide = room.order == "zyz" or np.max(room.angles[1] - room.angles[0]) > WIDE
        middle = np.column_stack([start[:, 0], (low + high)[:, 1:] / 2])
        for begun, tried in ((start, near | wide), (middle, ~near | wide)):
            rows = breaks[tried]
            x, J = minimise(_Objective(moments.take(rows), room), begun[rows], low[rows], high[rows], size[tried])
            lower = cost[rows] > J
            ends[rows[lower]], cost[rows[lower]] = x[lower], J[lower]
    return ends, cost


def _umeyama(moments: Moments, room: Room, sign: float) -> Array:
    """λ of this sign and the angles of R that fit best without bounds, (c, 4)."""
    R, s = nearest_rotation(sign * room.bracket.T @ moments.cross)
    scale = sign * s.sum(axis=1) / np.where(moments.pp > 0, moments.pp, 1.0)
    return np.column_stack([scale, angles_within(R, room.order, *room.angles)])


def _shift(moments: Moments, room: Room, scale: Array, R: Array) -> tuple[Array, Array]:
    """The best t, and what the bounds leave of the distance between the means, (c, 3) both."""
    wanted = moments.d - scale[:, None] * (room.bracket @ R @ moments.p[..., None])[..., 0]
    shift = np.clip(wanted, *room.shift)
    return shift, wanted - shift


class _Objective:
    """|d - (λ B R p + t)|² at the best t, of λ and three angles, with its derivatives."""

    def __init__(self, moments: Moments, room: Room) -> None:
        self._moments, self._room = moments, room
        self._cross = room.bracket.T @ moments.cross

    def __call__(self, x: Array, which: Ints) -> tuple[Array, Array, Array]:
        m, B = self._moments.take(which), self._room.bracket
        scale = x[:, 0]
        R, axes = turn(x[:, 1:], self._room.order)
        _, left = _shift(m, self._room, scale, R)
        bound = left != 0
        cross = self._cross[which]
        overlap = (R * cross).sum(axis=(1, 2))
        J = m.dd - 2 * scale * overlap + scale**2 * m.pp + m.count * (left**2).sum(axis=1)

        # <R, G> holds all that is linear in R: the points' overlap, and the pull of a shift on its bound
        pull = m.count * (left @ B)[:, :, None] * m.p[:, None, :]
        first, second = along(axes, (cross + pull) @ np.swapaxes(R, 1, 2))
        seen = (R @ m.p[..., None])[..., 0]
        moved = np.concatenate([seen[:, None], scale[:, None, None] * np.cross(axes, seen[:, None])], axis=1) @ B.T
        moved = np.where(bound[:, None], moved, 0.0)
        linear = overlap + (pull * R).sum(axis=(1, 2))
        g = 2 * np.column_stack([scale * m.pp - linear, -scale[:, None] * first])
        H = 2 * m.count * moved @ np.swapaxes(moved, 1, 2)
        H[:, 0, 0] += 2 * m.pp
        H[:, 0, 1:] -= 2 * first
        H[:, 1:, 0] -= 2 * first
        H[:, 1:, 1:] -= 2 * scale[:, None, None] * second
        return J, g, H


def _rows(values: Array, like: Array) -> Array:
    return np.broadcast_to(values, (len(like), len(values)))


def _squares(points: Array) -> Array:
    return np.asarray((points**2).sum(axis=(1, 2)))
