"""The course of a run: how far it had come at each pose, and which way the joints had moved."""

from itertools import pairwise

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Poses


def progress(time_s: Array, order: Ints, *, in_order: bool) -> Array:
    """Share of the run that had passed at each pose, (n,), from 0 to 1.

    Args:
        time_s: (n,) [s].
        order: Numbers of the poses as they followed one another, (n,).
        in_order: Count poses instead of seconds.
    """
    passed = np.empty(len(order))
    passed[order] = np.arange(len(order)) if in_order else time_s[order] - time_s[order[0]]
    whole = passed.max(initial=0.0)
    return np.asarray(passed / whole) if whole > 0 else passed


def temperature(poses: Poses) -> Array | None:
    """What a thermometer said at each pose, (n,) [°C]; None where it is not known at all of them."""
    return poses.temperature_c


def rise(poses: Poses) -> Array | None:
    """Temperature above the lowest over the largest such rise, (n,), 0 to 1; None where it is unknown or constant."""
    read = temperature(poses)
    if read is None or np.ptp(read) == 0:
        return None
    lifted: Array = (read - read.min()) / np.ptp(read)
    return lifted


def approached(q: Array, order: Ints) -> Array:
    """The way each joint moved last before each pose, (n, j) -> (n, j): +1, -1, or 0 where it has not moved yet."""
    way = np.zeros_like(q)
    for before, now in pairwise(order):
        moved = np.sign(q[now] - q[before])
        way[now] = np.where(moved == 0, way[before], moved)
    return way


def played(ahead: Array, moves: Array, half: Array) -> Array:
    """A play operator: what is driven hangs back by half the play, and follows only when pushed.

    Args:
        ahead: Of the driven side at the first pose, (c,), within the play.
        moves: Of the driving side from pose to pose, (c or 1, n - 1).
        half: Half the play, (c,), not negative.

    Returns:
        How far what is driven is ahead of what drives at every pose, (c, n).

    Source: Krasnoselskii, Pokrovskii 1989, Systems with Hysteresis.
    """
    out = np.empty((len(half), moves.shape[1] + 1))
    out[:, 0] = ahead
    for i in range(moves.shape[1]):
        out[:, i + 1] = np.clip(out[:, i] - moves[:, i], -half, half)
    return out
