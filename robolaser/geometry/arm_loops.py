"""From joint values to flange poses, candidate by candidate and pose by pose."""

from typing import Any

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled.loops import compiled
from robolaser.geometry.frame_loops import Frame, frame, times


@compiled
def forward(
    first: int,
    last: int,
    q: Array,
    chain: Ints,
    prismatic: Bools,
    placements: Array,
    to_axis: Array,
    from_axis: Array,
    end: Array,
    out: Array,
) -> None:
    """T_base_flange; axes of length one count for every candidate or pose.

    Args:
        first: First candidate.
        last: The one after the last.
        q: Joint values, (c or 1, n, j) [rad] or [m].
        chain: Joints from base to flange, (k,).
        prismatic: (j,).
        placements: Of each joint on the one before it, (c or 1, n or 1, j, 4, 4).
        to_axis: Turns that lay z along each joint's axis, (j, 4, 4).
        from_axis: Their inverses, (j, 4, 4).
        end: Last joint to flange, (4, 4).
        out: Takes the poses, (c, n, 4, 4).
    """
    k = len(chain)
    steps = np.empty((k, 3, 4))
    tip = frame(from_axis[chain[k - 1]])
    for i in range(first, last):
        at, of = i if len(q) > 1 else 0, i if len(placements) > 1 else 0
        for n in range(out.shape[1]):
            if placements.shape[1] > 1 or n == 0:
                _steps(placements[of, n], chain, to_axis, from_axis, steps)
            values = q[at, n if q.shape[1] > 1 else 0]
            T = _turned(frame(steps[0]), values[chain[0]], prismatic[chain[0]])
            for j in range(1, k):
                T = _turned(times(T, frame(steps[j])), values[chain[j]], prismatic[chain[j]])
            T = times(times(T, tip), frame(end))
            for row in range(3):
                for column in range(4):
                    out[i, n, row, column] = T[4 * row + column]
            out[i, n, 3, 0], out[i, n, 3, 1], out[i, n, 3, 2], out[i, n, 3, 3] = 0.0, 0.0, 0.0, 1.0


@compiled
def _steps(placements: Array, chain: Ints, to_axis: Array, from_axis: Array, steps: Array) -> None:
    """From each joint's frame with z along its axis to the next one's, (k, 3, 4)."""
    for j in range(len(chain)):
        T = times(frame(placements[chain[j]]), frame(to_axis[chain[j]]))
        if j > 0:
            T = times(frame(from_axis[chain[j - 1]]), T)
        for row in range(3):
            for column in range(4):
                steps[j, row, column] = T[4 * row + column]


@compiled
def _turned(T: Frame, value: float, slides: bool) -> Any:
    """A frame moved along or about its z."""
    x_0, y_0, z_0, p_0, x_1, y_1, z_1, p_1, x_2, y_2, z_2, p_2 = T
    if slides:
        p_0, p_1, p_2 = p_0 + value * z_0, p_1 + value * z_1, p_2 + value * z_2
        return (x_0, y_0, z_0, p_0, x_1, y_1, z_1, p_1, x_2, y_2, z_2, p_2)
    cos, sin = np.cos(value), np.sin(value)
    return (
        cos * x_0 + sin * y_0, cos * y_0 - sin * x_0, z_0, p_0,
        cos * x_1 + sin * y_1, cos * y_1 - sin * x_1, z_1, p_1,
        cos * x_2 + sin * y_2, cos * y_2 - sin * x_2, z_2, p_2,
    )  # fmt: skip
